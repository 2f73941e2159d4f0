// SPDX-License-Identifier: MIT
// Repeatable noise from counters: the hash pcg3d (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering", JCGT 9(3)).

uvec3 pcg3d(uvec3 v) {
  v = v * 1664525u + 1013904223u;
  v += v.yzx * v.zxy;
  v ^= v >> 16u;
  v += v.yzx * v.zxy;
  return v;
}

// Smooth interpolation of random values from 0 to 1 at the points of the unit lattice.
float valueNoise(vec3 p) {
  const vec3 cell = floor(p), t = p - cell, s = t * t * (3 - 2 * t);
  float sum = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const ivec3 offset = ivec3(corner & 1, corner >> 1 & 1, corner >> 2);
    const vec3 weight = mix(1 - s, s, vec3(offset));
    sum += weight.x * weight.y * weight.z * float(pcg3d(uvec3(ivec3(cell) + offset)).x) / 4294967296.0;
  }
  return sum;
}

// Octaves of valueNoise, each of twice the frequency and half the amplitude; from 0 to 1, mean 1/2.
float fractalNoise(vec3 p, int octaves) {
  float sum = 0, height = 1, total = 0;
  for (int i = 0; i < octaves; ++i) {
    sum += height * valueNoise(p);
    total += height;
    p = 2 * p + 17.3;
    height *= 0.5;
  }
  return sum / total;
}
