layout(location = 0) in vec3 local;
layout(location = 1) in vec3 outward;
layout(location = 2) in float end;  // 0 at the first point, 1 at the second
layout(location = 3) in ivec2 points;
layout(location = 4) in vec2 life;
layout(location = 5) in float radius;
uniform float behind;  // moves both points away from the second: where an opening's tube is
out vec3 facing;
out vec3 at;
out float value;

void main() {
  if (!isThere(life)) {
    gl_Position = NOWHERE;
    return;
  }
  value = ramp >= 0 ? mix(fieldOf(points.x), fieldOf(points.y), end) : 0.0;
  vec3 first = place(points.x), second = place(points.y);
  vec3 way = second - first;
  float length2 = dot(way, way);
  vec3 axis = length2 > 0.0 ? way * inversesqrt(length2) : vec3(0.0, 0.0, 1.0);
  vec3 side = abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
  if (length2 == 0.0) side = vec3(1.0, 0.0, 0.0);
  vec3 right = normalize(cross(side, axis)), up = cross(axis, right);
  if (behind > 0.0) {
    second = first;
    first -= axis * behind;
  }
  mat3 frame = mat3(right, up, axis);
  vec4 here = view * vec4(mix(first, second, end) + frame * local * radius, 1.0);
  at = here.xyz;
  facing = mat3(view) * frame * outward;
  gl_Position = projection * here;
}
// ---- fragment
in vec3 facing;
in vec3 at;
in float value;
uniform vec3 base;
out vec4 colour;

void main() {
  if (isCutOff(at)) discard;
  vec3 normal = normalize(facing);
  if (dot(normal, at) > 0.0) normal = -normal;
  vec3 seen = ramp >= 0 ? readable(fieldColour(value), normal, at)
    : hazy(lit(base, normal, at, GLOSS), -at.z, HAZE);
  colour = vec4(seen, 1.0);
}
