// SPDX-License-Identifier: MIT

vec3 rotate(vec4 q, vec3 v) { return v + 2 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }

vec4 conjugate(vec4 q) { return vec4(-q.xyz, q.w); }
