// SPDX-License-Identifier: MIT
// Checks a control cage by its directed edges, and by union-find over the face corners around each point.
#include "engine/mesh/manifold.h"

#include <algorithm>
#include <numeric>

#include "engine/core/error.h"

namespace airclay {
namespace {

/// A face's edge from one point to the next.
struct DirectedEdge {
  int from, to;
  int corner;       ///< the face corner at `from`, numbered over all faces
  int next_corner;  ///< the face corner at `to`
};

bool operator<(const DirectedEdge& a, const DirectedEdge& b) {
  return a.from != b.from ? a.from < b.from : a.to < b.to;
}

std::string named(int point) {
  return std::to_string(point + 1);
}

void checkFace(const std::vector<int>& face, size_t point_count, const std::string& where) {
  if (face.size() < 3)
    throw Error(where + " has " + std::to_string(face.size()) + " corners; expected at least three");
  std::vector<int> sorted = face;
  std::sort(sorted.begin(), sorted.end());
  if (sorted.front() < 0 || size_t(sorted.back()) >= point_count)
    throw Error(where + " has a corner out of range; expected points 1 to " + std::to_string(point_count));
  const auto twice = std::adjacent_find(sorted.begin(), sorted.end());
  if (twice != sorted.end())
    throw Error(where + " has point " + named(*twice) + " twice; expected different corners");
}

/// The directed edges of all faces, sorted by their ends.
std::vector<DirectedEdge> directedEdges(const PolygonMesh& cage) {
  std::vector<DirectedEdge> edges;
  int first_corner = 0;
  for (const std::vector<int>& face : cage.faces) {
    const int size = int(face.size());
    for (int k = 0; k < size; ++k) {
      const int next = (k + 1) % size;
      edges.push_back({face[size_t(k)], face[size_t(next)], first_corner + k, first_corner + next});
    }
    first_corner += size;
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

/// Null if the edge does not exist.
const DirectedEdge* findEdge(const std::vector<DirectedEdge>& edges, int from, int to) {
  const DirectedEdge key{from, to, 0, 0};
  const auto found = std::lower_bound(edges.begin(), edges.end(), key);
  return found != edges.end() && found->from == from && found->to == to ? &*found : nullptr;
}

void checkEdges(const std::vector<DirectedEdge>& edges, const std::string& where) {
  for (size_t i = 1; i < edges.size(); ++i) {
    const DirectedEdge& edge = edges[i];
    if (edges[i - 1] < edge) continue;
    const bool third =
        findEdge(edges, edge.to, edge.from) || (i + 1 < edges.size() && !(edge < edges[i + 1]));
    throw Error(
        where + ": the edge between points " + named(std::min(edge.from, edge.to)) + " and " +
        named(std::max(edge.from, edge.to)) + " is non-manifold: " +
        (third ? "it has more than two faces" : "its two faces have opposite orientation; flip one of them"));
  }
}

/// Disjoint sets of face corners (Tarjan's union-find, with path halving).
class CornerSets {
 public:
  explicit CornerSets(size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int corner) {
    while (parent_[size_t(corner)] != corner)
      corner = parent_[size_t(corner)] = parent_[size_t(parent_[size_t(corner)])];
    return corner;
  }
  void join(int a, int b) { parent_[size_t(find(a))] = find(b); }

 private:
  std::vector<int> parent_;
};

/// The faces at a point form one fan if each is reachable from every other across shared edges.
void checkPoints(const PolygonMesh& cage, const std::vector<DirectedEdge>& edges, const std::string& where) {
  CornerSets fans(edges.size());
  for (const DirectedEdge& edge : edges) {
    const DirectedEdge* opposite = edge.from < edge.to ? findEdge(edges, edge.to, edge.from) : nullptr;
    if (!opposite) continue;
    fans.join(edge.corner, opposite->next_corner);
    fans.join(edge.next_corner, opposite->corner);
  }
  std::vector<int> fan_of_point(cage.points.size(), -1);
  for (const DirectedEdge& edge : edges) {
    int& fan = fan_of_point[size_t(edge.from)];
    const int own = fans.find(edge.corner);
    if (fan >= 0 && fan != own)
      throw Error(where + ": point " + named(edge.from) +
                  " is non-manifold: two fans of faces meet only there; duplicate the point for each");
    fan = own;
  }
  const auto loose = std::find(fan_of_point.begin(), fan_of_point.end(), -1);
  if (loose != fan_of_point.end())
    throw Error(where + ": point " + named(int(loose - fan_of_point.begin())) +
                " has no face; remove it or use it in a face");
}

}  // namespace

void checkCage(const PolygonMesh& cage, const std::string& where) {
  if (cage.points.empty() || cage.faces.empty())
    throw Error(where + ": a control cage needs points and faces; this one has " +
                std::to_string(cage.points.size()) + " and " + std::to_string(cage.faces.size()));
  for (size_t f = 0; f < cage.faces.size(); ++f)
    checkFace(cage.faces[f], cage.points.size(), where + ": face " + std::to_string(f + 1));
  const std::vector<DirectedEdge> edges = directedEdges(cage);
  checkEdges(edges, where);
  checkPoints(cage, edges, where);
}

}  // namespace airclay
