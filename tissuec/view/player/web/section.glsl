layout(location = 0) in vec3 point;
layout(location = 1) in ivec2 ends;  // the nodes between which it lies
layout(location = 2) in float part;  // how far from the first to the second
uniform sampler2D tints;
uniform vec3 normal;  // to the eye
uniform float nearer;  // how far towards the eye
out vec3 facing;
out vec3 at;
out vec4 tint;
out float value;

void main() {
  tint = mix(texelFetch(tints, texel(ends.x), 0), texelFetch(tints, texel(ends.y), 0), part);
  value = ramp >= 0 ? mix(fieldOf(ends.x), fieldOf(ends.y), part) : 0.0;
  vec4 here = view * vec4(point, 1.0);
  here.xyz *= 1.0 - nearer / max(-here.z, nearer);
  at = here.xyz;
  facing = mat3(view) * normal;
  gl_Position = projection * here;
}
// ---- fragment
in vec3 facing;
in vec3 at;
in vec4 tint;
in float value;
uniform vec4 plain;  // colour of lines; nothing if its last number is 0
uniform float paler;
out vec4 colour;

void main() {
  vec3 base = mix(tint.rgb, paper, paler);
  vec3 seen = ramp >= 0 ? readable(fieldColour(value), facing, at)
    : hazy(lit(base, facing, at, SHINE * tint.a), -at.z, HAZE);
  colour = vec4(mix(seen, plain.rgb, plain.a), 1.0);
}
