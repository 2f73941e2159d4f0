// SPDX-License-Identifier: MIT
// Mirror images, packed as in symmetry_io.h, and how the images' requests for a data point combine.

uint imageCount(uint mirrors) { return findMSB(mirrors) / 4 + 1; }  // 0 for image 0 alone: findMSB(0) is -1, and -1 / 4 is 0

vec3 mirrorOf(uint mirrors, uint image) {
  const uint axes = mirrors >> (4 * image);
  return vec3((axes & 1) != 0 ? -1 : 1, (axes & 2) != 0 ? -1 : 1, (axes & 4) != 0 ? -1 : 1);
}

// The largest displacement in either direction, per axis.
struct Requests {
  vec3 up;
  vec3 down;
};

Requests noRequests() { return Requests(vec3(0), vec3(0)); }

void add(inout Requests requests, vec3 displacement) {
  requests.up = max(requests.up, displacement);
  requests.down = min(requests.down, displacement);
}

// The larger displacement if the images agree, the sum if they oppose each other.
vec3 combined(Requests requests) { return requests.up + requests.down; }
