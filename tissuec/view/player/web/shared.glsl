#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
// ---- rules
uniform mat4 view, projection;
uniform sampler2D places;
uniform float mixing;  // between the two frames
uniform float moment;  // in frames
uniform sampler2D value0, value1;
uniform int ramp;  // row of the colours of the field; -1 without a field
const int ACROSS = 1024;  // texels of a row

ivec2 texel(int i) { return ivec2(i % ACROSS, i / ACROSS); }

vec3 blend(sampler2D first, sampler2D second, int i) {
  ivec2 at = texel(i);
  return mix(texelFetch(first, at, 0).xyz, texelFetch(second, at, 0).xyz, mixing);
}

vec3 place(int i) { return texelFetch(places, texel(i), 0).xyz; }

// The number of the field at a node.
float fieldOf(int node) {
  ivec2 at = texel(node);
  return mix(texelFetch(value0, at, 0).r, texelFetch(value1, at, 0).r, mixing);
}

bool isThere(vec2 life) { return life.x <= moment && moment < life.y; }

const vec4 NOWHERE = vec4(2.0, 2.0, 2.0, 1.0);
// ---- fragment
#version 300 es
precision highp float;
precision highp int;
precision highp sampler2D;
// ---- rules
uniform vec3 paper;
uniform vec2 haze;  // distances from the eye at which it begins, and is thickest
uniform sampler2D colours;
uniform int ramp;  // row of the colours of the field; -1 without a field
uniform vec2 range;  // numbers at the ends of its colours
uniform int isLog;  // whether these follow logarithms

// The colour of a number of the field; grey where it is unknown.
vec3 fieldColour(float value) {
  if (value < -1e37) return vec3(UNKNOWN);
  float part = isLog == 1 ? log(max(value, 1e-37) / range.x) / log(range.y / range.x)
    : (value - range.x) / (range.y - range.x);
  part = clamp(part, 0.0, 1.0);
  return texelFetch(colours, ivec2(int(round(255.0 * part)), ramp), 0).rgb;
}

// A colour with so little shade that it can be compared with the legend.
vec3 readable(vec3 base, vec3 normal, vec3 at) {
  return base * (LIT + (1.0 - LIT) * abs(dot(normal, normalize(-at))));
}

uniform vec4 cut;  // normal of the section, as the eye sees it, and its offset

// Whether a point is in front of the section.
bool isCutOff(vec3 at) { return dot(cut.xyz, at) > cut.w; }

vec3 hazy(vec3 colour, float away, float most) {
  return mix(colour, paper, most * smoothstep(haze.x, haze.y, away));
}

// Light from the upper left, a sky, and a soft highlight; all as seen by the eye.
vec3 lit(vec3 base, vec3 normal, vec3 at, float shine) {
  const vec3 lamp = normalize(LAMP);
  vec3 toEye = normalize(-at);
  float direct = max(dot(normal, lamp), 0.0);
  float sky = 0.5 + 0.5 * normal.y;
  float aslant = 1.0 - max(dot(normal, toEye), 0.0);
  float rim = aslant * aslant * aslant;
  float spot = max(dot(reflect(-lamp, normal), toEye), 0.0);
  spot *= spot;
  spot *= spot;
  spot *= spot;
  spot *= spot * spot;  // to the power of 24
  vec3 linear = base * base;
  vec3 sum = linear * (0.22 + 0.26 * sky + 0.7 * direct + 0.12 * rim) + shine * spot;
  return sqrt(clamp(sum, 0.0, 1.0));
}
