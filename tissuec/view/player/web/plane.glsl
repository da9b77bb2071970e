layout(location = 0) in vec2 corner;
uniform ivec2 points;
uniform vec3 middle;  // of the scene
uniform float size;
out vec2 across;
out vec2 local;
out vec3 facing;
out vec3 at;

void main() {
  vec3 first = place(points.x);
  vec3 axis = normalize(place(points.y) - first);
  vec3 side = abs(axis.z) < 0.9 ? vec3(0.0, 0.0, 1.0) : vec3(1.0, 0.0, 0.0);
  vec3 right = normalize(cross(side, axis)), up = cross(axis, right);
  vec3 foot = middle - axis * dot(middle - first, axis);
  across = local = corner * size;
  vec4 here = view * vec4(foot + right * across.x + up * across.y, 1.0);
  // The grid stays where it is while the eye follows the scene.
  across += vec2(dot(foot - first, right), dot(foot - first, up));
  at = here.xyz;
  facing = mat3(view) * axis;
  gl_Position = projection * here;
}
// ---- fragment
in vec2 across;
in vec2 local;
in vec3 facing;
in vec3 at;
uniform vec3 base;
uniform float cell, size;
out vec4 colour;

void main() {
  vec2 grid = abs(fract(across / cell - 0.5) - 0.5) * cell;
  vec2 fine = fwidth(across);
  float line = 1.0 - min(smoothstep(0.0, 1.5 * fine.x, grid.x), smoothstep(0.0, 1.5 * fine.y, grid.y));
  vec3 normal = normalize(facing);
  if (dot(normal, at) > 0.0) normal = -normal;
  float edge = 1.0 - smoothstep(0.55, 1.0, length(local) / size);
  float opacity = edge * (0.30 + 0.35 * line);
  colour = vec4(lit(base, normal, at, 0.0) * opacity, opacity);
}
