layout(location = 0) in int node;
layout(location = 1) in vec2 life;
layout(location = 2) in vec2 patched;  // when it is held
uniform sampler2D normal0, normal1;
uniform int byCorner;  // 0: there is a normal for each point, 1: for each corner, 2: none
out vec3 facing;
out vec3 at;
out float held;

void main() {
  if (!isThere(life)) {
    gl_Position = NOWHERE;
    return;
  }
  vec4 here = view * vec4(place(node), 1.0);
  at = here.xyz;
  held = patched.x <= moment && moment < patched.y ? 0.75 : 0.0;
  facing = mat3(view) * (byCorner == 2 ? vec3(0.0)
    : blend(normal0, normal1, byCorner == 1 ? gl_VertexID : node));
  gl_Position = projection * here;
}
// ---- fragment
in vec3 facing;
in vec3 at;
in float held;
uniform vec3 outside, inside, steel;
uniform float opacity;
out vec4 colour;

void main() {
  vec3 normal = normalize(facing);
  if (dot(facing, facing) < 1e-20) normal = normalize(cross(dFdx(at), dFdy(at)));
  vec3 base = gl_FrontFacing ? mix(outside, steel, held) : inside;
  if (dot(normal, at) > 0.0) normal = -normal;
  vec3 seen = hazy(lit(base, normal, at, 0.06), -at.z, 0.35);
  colour = vec4(seen * opacity, opacity);
}
