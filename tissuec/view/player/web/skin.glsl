layout(location = 0) in vec2 part;  // weights of the second and third corner
layout(location = 1) in ivec3 corners;  // of flat triangles, the first alone
layout(location = 2) in vec2 life;
layout(location = 3) in vec2 patched;  // when it is held
layout(location = 4) in float hollow;
uniform sampler2D normal0, normal1, bulge0, bulge1, tints;
uniform int byCorner;  // 0: there is a normal for each point, 1: for each corner, 2: none
uniform int isRounded;  // in parts that follow the normals
uniform int points;  // of each triangle
uniform vec4 plain;  // colour and gloss of everything, unless the gloss is negative
out vec3 facing;
out vec3 at;
out vec4 tint;
out float held, inner, value;

vec3 normal(int node, int corner) {
  if (byCorner == 2) return vec3(0.0);
  return blend(normal0, normal1, byCorner == 1 ? corner : node);
}

void main() {
  if (!isThere(life)) {
    gl_Position = NOWHERE;
    return;
  }
  vec3 point = vec3(0.0);
  tint = plain;
  value = 0.0;
  if (isRounded == 0) {
    int node = corners.x;
    point = place(node);
    facing = normal(node, gl_VertexID);
    if (ramp >= 0) value = fieldOf(node);
    if (plain.w < 0.0) tint = texelFetch(tints, texel(node), 0);
  } else {
    int first = 3 * (gl_VertexID / points);
    vec3 w = vec3(1.0 - part.x - part.y, part);
    facing = vec3(0.0);
    tint = vec4(0.0);
    for (int i = 0; i < 3; i += 1) {
      point += w[i] * place(corners[i]);
      facing += w[i] * normal(corners[i], first + i);
      if (ramp >= 0) value += w[i] * fieldOf(corners[i]);
      tint += w[i] * texelFetch(tints, texel(corners[i]), 0);
      // An edge bends towards the normals at its ends; see bodies.py.
      point += 0.5 * w[i] * w[(i + 1) % 3] * blend(bulge0, bulge1, first + i);
    }
  }
  vec4 here = view * vec4(point, 1.0);
  at = here.xyz;
  held = patched.x <= moment && moment < patched.y ? HELD : 0.0;
  inner = hollow;
  facing = mat3(view) * facing;
  gl_Position = projection * here;
}
// ---- fragment
in vec3 facing;
in vec3 at;
in vec4 tint;
in float held, inner, value;
uniform vec3 inside, steel;
uniform float opacity, paler;
out vec4 colour;

void main() {
  if (isCutOff(at)) discard;
  vec3 normal = normalize(facing);
  if (dot(facing, facing) < 1e-20) normal = normalize(cross(dFdx(at), dFdy(at)));
  vec3 outside = mix(mix(tint.rgb, steel, held), paper, paler);
  vec3 base = gl_FrontFacing || inner < 0.5 ? outside : inside;
  if (dot(normal, at) > 0.0) normal = -normal;
  vec3 seen = ramp >= 0 ? readable(fieldColour(value), normal, at)
    : hazy(lit(base, normal, at, SHINE * tint.a), -at.z, HAZE);
  colour = vec4(seen * opacity, opacity);
}
