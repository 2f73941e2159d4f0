// SPDX-License-Identifier: MIT
// tinygltf's implementation, compiled into the engine and hidden. The shared libtinygltf.so would not do:
// libdraco.so, which assimp and others load, exports functions of the same names with another layout of the
// classes.
#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_STB_IMAGE  // there are no textures
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>
