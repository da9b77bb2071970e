layout(location = 0) in vec3 local;
layout(location = 1) in vec3 outward;
layout(location = 2) in float part;  // 0: of the shaft, 1 and 2: jaws, 3: stretched
uniform ivec4 points;  // origin, on z, on x, and on z by the setting
uniform float size, pivot;
out vec3 facing;
out vec3 at;

void main() {
  vec3 origin = place(points.x);
  vec3 z = normalize(place(points.y) - origin), x = place(points.z) - origin;
  x = normalize(x - dot(x, z) * z);
  float setting = dot(place(points.w) - origin, z) / size;
  vec3 point = local, normal = outward;
  if (part > 2.5) point.z *= setting;
  else if (part > 0.5) {
    float turn = part > 1.5 ? -setting : setting, c = cos(turn), s = sin(turn);
    point.z -= pivot;
    point.xz = vec2(c * point.x - s * point.z, s * point.x + c * point.z);
    point.z += pivot;
    normal.xz = vec2(c * normal.x - s * normal.z, s * normal.x + c * normal.z);
  }
  mat3 frame = mat3(x, cross(z, x), z);
  vec4 here = view * vec4(origin + frame * point * size, 1.0);
  at = here.xyz;
  facing = mat3(view) * frame * normal;
  gl_Position = projection * here;
}
// ---- fragment
in vec3 facing;
in vec3 at;
uniform vec3 base;
out vec4 colour;

void main() {
  vec3 normal = normalize(facing);
  if (dot(normal, at) > 0.0) normal = -normal;
  colour = vec4(hazy(lit(base, normal, at, GLOSS), -at.z, HAZE), 1.0);
}
