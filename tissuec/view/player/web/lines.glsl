layout(location = 1) in ivec2 ends;
layout(location = 2) in vec2 life;
layout(location = 3) in float rest;
layout(location = 4) in float law;
layout(location = 5) in float tension0;
layout(location = 6) in float tension1;
uniform vec2 screen;  // pixels
uniform float width;  // pixels, at the target
uniform float nearer;  // how far towards the eye, so that lines lie on the skin
uniform float distance;  // of the target
uniform float dashes;  // length of one
uniform int colouring;  // 0 tension, 1 strain, 2 law, 3 the field
uniform float mostStrain;
uniform sampler2D colours;
out vec3 tint;
out float shade;
out float along;
out float dashed;
out float away;
out vec3 eyed;

void main() {
  // Four corners of each line: along, 0 or 1, and across, -1 or 1.
  vec2 corner = vec2(float((gl_VertexID >> 1) & 1), float(2 * (gl_VertexID & 1) - 1));
  if (!isThere(life)) {
    gl_Position = NOWHERE;
    return;
  }
  vec3 first = place(ends.x), second = place(ends.y);
  float length = sqrt(dot(second - first, second - first));
  vec3 a = (view * vec4(first, 1.0)).xyz, b = (view * vec4(second, 1.0)).xyz;
  float least = -0.02 * distance;  // in front of the eye
  if (a.z > least && b.z > least) {
    gl_Position = NOWHERE;
    return;
  }
  if (a.z > least) a = mix(b, a, (least - b.z) / (a.z - b.z));
  if (b.z > least) b = mix(a, b, (least - a.z) / (b.z - a.z));
  a *= 1.0 - nearer / max(-a.z, nearer);
  b *= 1.0 - nearer / max(-b.z, nearer);
  vec4 from = projection * vec4(a, 1.0), to = projection * vec4(b, 1.0);
  vec4 here = corner.x < 0.5 ? from : to;
  vec2 way = (to.xy / to.w - from.xy / from.w) * screen;
  float size = sqrt(dot(way, way));
  vec2 side = size > 1e-3 ? vec2(-way.y, way.x) / size : vec2(0.0, 1.0);
  float value = colouring == 0 ? mix(tension0, tension1, mixing)
              : rest > 0.0 ? (length / rest - 1.0) / mostStrain : 0.0;
  value = clamp(value, -1.0, 1.0);
  shade = colouring == 3 ? fieldOf(corner.x < 0.5 ? ends.x : ends.y) : 0.0;
  float wide = colouring > 1 ? 1.0 : 0.75 + 0.75 * abs(value);
  wide *= width * clamp(distance / here.w, 0.35, 2.0);
  here.xy += side * corner.y * wide / screen * here.w;
  gl_Position = here;
  ivec2 at = colouring == 2 ? ivec2(int(law) % 7, 1) : ivec2(int(round(127.5 + 127.5 * value)), 0);
  tint = texelFetch(colours, at, 0).rgb;
  along = corner.x * length / dashes;
  dashed = colouring == 2 ? float(int(law) / 7 > 0) : colouring < 2 && value < -PRESSED ? 1.0 : 0.0;
  away = here.w;
  eyed = corner.x < 0.5 ? a : b;
}
// ---- fragment
in vec3 tint;
in float shade;
in float along;
in float dashed;
in float away;
in vec3 eyed;
out vec4 colour;

void main() {
  if (isCutOff(eyed)) discard;
  if (dashed > 0.5 && fract(along + 0.25) > INKED) discard;
  colour = vec4(ramp >= 0 ? fieldColour(shade) : hazy(tint, away, FOG), 1.0);
}
