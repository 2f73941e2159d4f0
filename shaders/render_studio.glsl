// SPDX-License-Identifier: MIT
// The studio: a soft warm key light, a hemisphere of sky and of light thrown back by the ground, a gentle rim.

const vec3 kKeyLight = vec3(1.75, 1.62, 1.45);
const vec3 kSkyLight = vec3(0.62, 0.66, 0.72);
const vec3 kBounceLight = vec3(0.36, 0.33, 0.30);

struct Material {
  vec3 albedo;
  float wrap;       // how far diffuse light reaches round the shade's edge, 0 to 1
  float gloss;      // the highlight's strength
  float sharpness;  // and exponent
  float rim;
};

// What leaves a surface towards the eye. `arrives`: share of the key light; `open`: to the light all around.
// `upward`: the normal's part along z.
vec3 studio(Material m, vec3 n, float upward, vec3 to_eye, vec3 to_key, float arrives, float open) {
  const float facing = dot(n, to_key);
  const float key = max((facing + m.wrap) / (1 + m.wrap), 0) * arrives;
  const vec3 around = mix(kBounceLight, kSkyLight, 0.5 + 0.5 * upward) * open;
  vec3 light = m.albedo * (kKeyLight * key + around);
  // light that meets walls of its own colour comes back coloured: openness darkens the channels unequally
  light *= mix(sqrt(m.albedo / max(m.albedo.r, max(m.albedo.g, m.albedo.b))), vec3(1), open);
  const vec3 half_way = normalize(to_key + to_eye);
  light += m.gloss * kKeyLight * pow(max(dot(n, half_way), 0), m.sharpness) * arrives * step(0, facing);
  const float grazing = pow(1 - max(dot(n, to_eye), 0), 4);
  light += m.rim * kSkyLight * grazing * open * (0.4 + 0.6 * clamp(upward + 0.6, 0, 1));
  return light;
}

// Strong light bends into white instead of being cut.
vec3 exposed(vec3 light) {
  const vec3 knee = max(light - 0.6, 0);
  return min(light, 0.6) + 0.4 * (1 - exp(-knee / 0.4));
}
