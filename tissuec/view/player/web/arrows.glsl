layout(location = 0) in vec3 local;  // around the shaft, and along: 0 foot, 1 neck, 2 collar, 3 tip
layout(location = 1) in vec3 outward;
uniform sampler2D force0, force1;
uniform float reach;  // length of an arrow over its force
uniform float thick;  // radius of a shaft
out vec3 facing;
out vec3 at;

void main() {
  vec3 arrow = blend(force0, force1, gl_InstanceID) * reach;
  float length = sqrt(dot(arrow, arrow));
  if (length < SHORTEST * thick) {  // a speck
    gl_Position = NOWHERE;
    return;
  }
  vec3 axis = arrow / length;
  vec3 side = abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
  vec3 right = normalize(cross(side, axis));
  mat3 frame = mat3(right, cross(axis, right), axis);
  float slim = min(1.0, length / (9.0 * thick)) * thick;
  float head = min(6.0 * slim, 0.45 * length);
  float along = local.z < 0.5 ? 0.0 : local.z < 2.5 ? length - head : length;
  float wide = local.z < 1.5 ? slim : local.z < 2.5 ? 2.4 * slim : 0.0;
  vec3 foot = place(gl_InstanceID);
  vec4 here = view * vec4(foot + frame * vec3(local.xy * wide, along), 1.0);
  at = here.xyz;
  facing = mat3(view) * frame * outward;
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
  colour = vec4(hazy(lit(base, normal, at, 0.1), -at.z, HAZE), 1.0);
}
