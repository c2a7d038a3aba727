// Programs of the graphics card: the sky, surfaces with light and shadow, the ground, and depths for the
// shadow.

const SHADOW_SIZE = 2048; // texels of a side

const WHOLE_VERTEX = `#version 300 es
out float height;
void main() {
  vec2 at = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0;
  height = 0.5 + 0.5 * at.y;
  gl_Position = vec4(at, 0.0, 1.0);
}`;

const SKY_FRAGMENT = `#version 300 es
precision mediump float;
in float height;
uniform vec3 zenith, horizon;
out vec4 result;
void main() { result = vec4(mix(horizon, zenith, clamp((height - 0.3) / 0.7, 0.0, 1.0)), 1.0); }`;

// What was kept of a frame before.
const KEPT_FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D colours;
uniform highp sampler2D depths;
out vec4 result;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  result = texelFetch(colours, at, 0);
  gl_FragDepth = texelFetch(depths, at, 0).r;
}`;

const SURFACE_VERTEX = `#version 300 es
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 model, view, light;
uniform highp int blur;
out vec3 place, facing;
out vec4 lit;
void main() {
  vec4 world = model * vec4(position, 1.0);
  place = world.xyz;
  facing = mat3(model) * normal;
  lit = blur < 0 ? vec4(0.0) : light * world;
  gl_Position = view * world;
}`;

const SHADOW = `
uniform highp sampler2DShadow shadow;
uniform highp int blur; // texels of the shadow's edge; without a shadow below 0
in vec4 lit;
float sunlight(float bias) {
  if (blur < 0) return 1.0;
  vec3 at = 0.5 * lit.xyz + 0.5;
  if (at.x < 0.0 || at.x > 1.0 || at.y < 0.0 || at.y > 1.0 || at.z > 1.0) return 1.0;
  float sum = 0.0;
  for (int i = -blur; i <= blur; i++)
    for (int j = -blur; j <= blur; j++)
      sum += texture(shadow, vec3(at.xy + vec2(i, j) / ${SHADOW_SIZE}.0, at.z - bias));
  return sum / float((2 * blur + 1) * (2 * blur + 1));
}`;

const SURFACE_FRAGMENT = `#version 300 es
precision highp float;
in vec3 place, facing;
uniform vec3 colour, eye, sun; // the colour as amounts of light
uniform float opacity;
out vec4 result;
${SHADOW}
void main() {
  vec3 n = normalize(gl_FrontFacing ? facing : -facing), v = normalize(eye - place);
  float key = max(dot(n, sun), 0.0);
  if (key > 0.0) key *= sunlight(0.0025 + 0.004 * (1.0 - key));
  vec3 sky = mix(vec3(0.26, 0.25, 0.24), vec3(0.44, 0.46, 0.50), 0.5 + 0.5 * n.z);
  float fill = 0.16 * max(dot(n, normalize(v + vec3(0.0, 0.0, 0.2))), 0.0);
  float gloss = max(dot(n, normalize(v + sun)), 0.0), edge = 1.0 - max(dot(n, v), 0.0);
  gloss *= gloss; gloss *= gloss; gloss *= gloss; gloss *= gloss; // to the 16th
  float shine = gloss * gloss * gloss * step(0.001, key), rim = 0.10 * edge * edge * edge;
  vec3 light = colour * (sky + fill + vec3(0.62, 0.60, 0.56) * key) + vec3(0.10 * shine * key + rim * 0.4);
  result = vec4(pow(light, vec3(1.0 / 2.2)), opacity);
}`;

const GROUND_FRAGMENT = `#version 300 es
precision highp float;
in vec3 place, facing;
uniform float reach;
out vec4 result;
${SHADOW}
float lines(vec2 at, float width) {
  vec2 cell = abs(fract(at - 0.5) - 0.5), blur = fwidth(at);
  vec2 line = 1.0 - smoothstep(vec2(0.0), width * blur, cell);
  return max(line.x, line.y) * (1.0 - clamp(max(blur.x, blur.y) * 3.0, 0.0, 1.0));
}
void main() {
  float fade = 1.0 - smoothstep(0.35 * reach, reach, length(place.xy));
  float grid = 0.10 * lines(10.0 * place.xy, 1.1) + 0.22 * lines(2.0 * place.xy, 1.3);
  float shade = 0.38 * (1.0 - sunlight(0.002));
  result = vec4(mix(vec3(0.35, 0.42, 0.50), vec3(0.10, 0.13, 0.18), step(grid, shade)),
                max(grid, shade) * fade);
}`;

const DEPTH_FRAGMENT = `#version 300 es
precision mediump float;
void main() {}`;
