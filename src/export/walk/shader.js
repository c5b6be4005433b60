// How light becomes colours: the same steps, and the same numbers, as in pictures that are rendered.

// The middle of an element is the last corner of its triangles, and the one whose values are flat.
const VERTEX = `
in vec3 position;
in vec4 light;
uniform mat4 modelViewMatrix, projectionMatrix;
out vec3 radiance;
out float inside;
flat out float mark;
void main() {
  radiance = light.rgb;
  inside = min(light.a, 1.0);
  mark = light.a;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const FRAGMENT = `
precision highp float;
precision highp int;
in vec3 radiance;
in float inside;
flat in float mark;
uniform float exposure, near, far, ratio, height;
uniform bool filmic, mesh, classes;
uniform vec3 colours[4];
out vec4 shown;

const float KNEE = 0.45;

vec3 filmicOf(vec3 rgb) {
  float peak = max(rgb.r, max(rgb.g, rgb.b));
  if (peak <= KNEE) return rgb;
  float mapped = KNEE + (1.0 - KNEE) * (1.0 - exp(-(peak - KNEE) / (1.0 - KNEE)));
  float scale = mapped / peak;
  vec3 kept = rgb * scale;
  return clamp(kept + (mapped - kept) * (1.0 - scale) * (1.0 - scale), 0.0, 1.0);
}

// IEC 61966-2-1.
vec3 srgbOf(vec3 linear) {
  vec3 bent = 1.0 + 1.055 * (pow(linear, vec3(1.0 / 2.4)) - 1.0);
  return mix(bent, 12.92 * linear, vec3(lessThanEqual(linear, vec3(0.0031308))));
}

// Against banding: thresholds spread evenly over the pixels of the page.
float dither() {
  uint x = uint(gl_FragCoord.x / ratio), y = uint((height - gl_FragCoord.y) / ratio);
  uint phase = x * 0xC13FA9A9u + y * 0x91E10DA5u;
  return float(phase >> 8) / 16777216.0;
}

void main() {
  // Depth by its logarithm: as exact, relative to the distance, at the other end of the scene as before one's feet.
  gl_FragDepth = clamp(-log2(gl_FragCoord.w * near) / log2(far / near), 0.0, 1.0);

  vec3 rgb = min(max(radiance, 0.0) * exposure, 1e30);
  vec3 displayed = filmic ? filmicOf(rgb) : min(rgb, 1.0);
  if (classes) displayed = colours[int(mark + 0.5) - 1];

  // Pixels from the middle of the element to its edge, and from here to it.
  float steepness = max(length(vec2(dFdx(inside), dFdy(inside))), 1e-12);
  float line = clamp(1.0 - inside / (steepness * 0.7 * ratio), 0.0, 1.0);
  // Fainter where elements are small.
  float faint = min(1.0, 2.0 / (steepness * 24.0 * ratio));
  if (classes) displayed *= 1.0 - 0.5 * faint * line;
  if (mesh) {
    float brightness = dot(displayed, vec3(0.2126, 0.7152, 0.0722));
    vec3 ink = brightness > 0.03 ? displayed * 0.2 : displayed + 0.15;
    displayed = mix(displayed, min(ink, 1.0), faint * line);
  }
  shown = vec4(min(floor(srgbOf(displayed) * 255.0 + dither()), 255.0) / 255.0, 1.0);
}`;

/** Linear value of a byte of sRGB. */
const linearOf = byte => {
  const encoded = byte / 255;
  return encoded <= 0.04045 ? encoded / 12.92 : ((encoded + 0.055) / 1.055) ** 2.4;
};
