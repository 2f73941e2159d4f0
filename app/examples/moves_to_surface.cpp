// SPDX-License-Identifier: MIT
// A control cage and moved data points to the cage that follows them and its surface. On the CPU, in double
// precision; no GPU is needed.
//
//     moves_to_surface CAGE.obj|PRESET MOVES.csv NEW_CAGE.obj SURFACE.obj
//
// MOVES.csv has the header index,x,y,z and one moved data point per line: its index in the surface subdivided
// kLevels times, and where it goes, in metres.
#include <airclay/engine/clay/presets.h>
#include <airclay/engine/clay/solve.h>
#include <airclay/engine/core/error.h>
#include <airclay/engine/mesh/mesh_file.h>

#include <cstdio>

using namespace airclay;

constexpr int kLevels = 2;

int main(int argc, char** argv) {
  if (argc != 5) {
    std::fprintf(stderr, "usage: moves_to_surface CAGE.obj|PRESET MOVES.csv NEW_CAGE.obj SURFACE.obj\n");
    return 2;
  }
  try {
    PolygonMesh cage = loadCage(argv[1]).cage;
    const Subdivision subdivision = subdivide(cage, kLevels, SubdivisionRule::kCatmullClark);
    const std::vector<Move> moves = readMoves(argv[2], static_cast<int>(subdivision.matrix.rows()));
    cage.points = solveControlPoints(subdivision.matrix, cage.points, moves, &kSolveTouched);
    const PolygonMesh surface = surfaceMesh(subdivision, cage.points);
    writeObj(argv[3], cage);
    writeObj(argv[4], surface);
    std::printf("%zu control points, %zu data points\n", cage.points.size(), surface.points.size());
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
