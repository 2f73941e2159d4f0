// SPDX-License-Identifier: MIT
// Studio lighting: a soft warm key light, a hemisphere of sky and ground bounce light, a gentle rim light.

const vec3 kKeyLight = vec3(1.75, 1.62, 1.45);
const vec3 kSkyLight = vec3(0.62, 0.66, 0.72);
const vec3 kBounceLight = vec3(0.36, 0.33, 0.30);

struct Material {
  vec3 albedo;
  float wrap;       // how far diffuse light reaches past the terminator, 0 to 1
  float gloss;      // the highlight's strength
  float sharpness;  // the highlight's exponent
  float rim;
};

// Approximates x to the power of s without pow (Schlick 1994, "A Fast Alternative to Phong's Specular Model").
float highlight(float x, float s) { return x / (s - s * x + x); }

// The light from a surface towards the eye; all directions have unit length. `arrives`: fraction of the key light; `open`: openness to
// ambient light. `upward`: z component of the normal.
vec3 studio(Material m, vec3 n, float upward, vec3 to_eye, vec3 to_key, float arrives, float open) {
  const float facing = dot(n, to_key);
  const float key = max((facing + m.wrap) / (1 + m.wrap), 0) * arrives;
  const vec3 around = mix(kBounceLight, kSkyLight, 0.5 + 0.5 * upward) * open;
  vec3 light = m.albedo * (kKeyLight * key + around);
  // interreflected light takes on the surface's colour: openness darkens the channels unequally
  light *= mix(0.5 + 0.5 / max(m.albedo.r, max(m.albedo.g, m.albedo.b)) * m.albedo, vec3(1), open);
  const float half_way = (facing + dot(n, to_eye)) * inversesqrt(2.001 + 2 * dot(to_key, to_eye));
  light += m.gloss * highlight(max(half_way, 0), m.sharpness) * arrives * step(0, facing) * kKeyLight;
  const float aslant = 1 - max(dot(n, to_eye), 0), grazing = (aslant * aslant) * (aslant * aslant);
  light += m.rim * kSkyLight * grazing * open * (0.4 + 0.6 * clamp(upward + 0.6, 0, 1));
  return light;
}

// Compresses strong light towards white instead of clipping it.
vec3 exposed(vec3 light) {
  const vec3 knee = max(light - 0.6, 0);
  return min(light, 0.6) + 0.5 * knee / (0.5 + knee);
}
