// SPDX-License-Identifier: MIT
// The hand's distance function. The including shader's arguments must have a member `hand`.

// Signed distance to the hand by trilinear interpolation; outside the grid, the border's value plus the distance to the border.
float distanceAt(vec3 point) {
  const uvec3 size = uvec3(args.hand.size_x, args.hand.size_y, args.hand.size_z);
  const vec3 wanted = (point - args.hand.low_corner) / args.hand.cell_m;
  const vec3 place = clamp(wanted, vec3(0), vec3(size - 1));
  const uvec3 low = min(uvec3(place), size - 2);
  const vec3 share = place - vec3(low);
  const uint dy = args.hand.size_x, dz = args.hand.size_x * args.hand.size_y;
  const uint i = low.x + dy * low.y + dz * low.z;
  const vec4 near = vec4(args.hand.values.at[i], args.hand.values.at[i + dy], args.hand.values.at[i + dz],
                         args.hand.values.at[i + dy + dz]);
  const vec4 far = vec4(args.hand.values.at[i + 1], args.hand.values.at[i + dy + 1], args.hand.values.at[i + dz + 1],
                        args.hand.values.at[i + dy + dz + 1]);
  const vec4 x = mix(near, far, share.x);
  const vec2 y = mix(x.xz, x.yw, share.y);
  return mix(y.x, y.y, share.z) + args.hand.cell_m * length(wanted - place);
}
