// SPDX-License-Identifier: MIT

vec3 rotate(vec4 q, vec3 v) { return v + 2 * cross(q.xyz, cross(q.xyz, v) + q.w * v); }

vec4 conjugate(vec4 q) { return vec4(-q.xyz, q.w); }

vec4 multiply(vec4 a, vec4 b) { return vec4(a.w * b.xyz + b.w * a.xyz + cross(a.xyz, b.xyz), a.w * b.w - dot(a.xyz, b.xyz)); }
