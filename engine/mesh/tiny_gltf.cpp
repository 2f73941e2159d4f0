// SPDX-License-Identifier: MIT
// tinygltf's implementation, compiled into the engine with hidden symbols. The shared libtinygltf.so does not
// work: libdraco.so, which assimp and others load, exports functions of the same names with a different class
// layout.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE  // there are no textures
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>
