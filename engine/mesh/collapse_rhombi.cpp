// SPDX-License-Identifier: MIT
#include <algorithm>

#include "engine/mesh/dual_contour.h"

namespace airclay {
namespace {

/// A net that changes, with the quads of each point.
class Collapser {
 public:
  explicit Collapser(QuadNet& net)
      : net_(net), quads_of_point_(net.points.size()), alive_(net.quads.size(), 1) {
    for (std::size_t q = 0; q < net.quads.size(); ++q)
      for (const int corner : net.quads[q]) quads_of_point_[corner].push_back(int(q));
  }

  void run() {
    bool changed = true;
    while (changed) {
      changed = false;
      for (std::size_t q = 0; q < net_.quads.size(); ++q)
        changed |= alive_[q] && (collapse(int(q), 0) || collapse(int(q), 1));
    }
    removeUnused();
  }

 private:
  std::size_t valence(int point) const { return quads_of_point_[point].size(); }

  /// Merges corners k and k + 2 of the quad, if that improves the net and keeps it manifold.
  bool collapse(int quad, int k) {
    const std::array<int, 4> corners = net_.quads[quad];
    const int a = corners[k], b = corners[k + 1], c = corners[k + 2], d = corners[(k + 3) % 4];
    if (valence(a) != 3 || valence(c) != 3 || valence(b) < 5 || valence(d) < 5) return false;
    if (net_.features[a] != Feature::kSmooth && net_.features[c] != Feature::kSmooth) return false;
    if (!haveOnlyInCommon(a, c, b, d)) return false;
    const bool to_mean = net_.features[a] == net_.features[c];
    if (to_mean) net_.points[a] = (net_.points[a] + net_.points[c]) / 2;
    if (net_.features[c] != Feature::kSmooth) {
      net_.points[a] = net_.points[c];
      net_.features[a] = net_.features[c];
    }
    alive_[quad] = 0;
    for (const int corner : corners) std::erase(quads_of_point_[corner], quad);
    for (const int other : quads_of_point_[c]) {
      std::replace(net_.quads[other].begin(), net_.quads[other].end(), c, a);
      quads_of_point_[a].push_back(other);
    }
    quads_of_point_[c].clear();
    return true;
  }

  /// Whether no quad contains a and c except the one between b and d, and no other point shares quads with
  /// both.
  bool haveOnlyInCommon(int a, int c, int b, int d) const {
    std::vector<int> around_a;
    for (const int quad : quads_of_point_[a])
      around_a.insert(around_a.end(), net_.quads[quad].begin(), net_.quads[quad].end());
    int shared_quads = 0;
    for (const int quad : quads_of_point_[c]) {
      shared_quads +=
          std::find(net_.quads[quad].begin(), net_.quads[quad].end(), a) != net_.quads[quad].end();
      for (const int corner : net_.quads[quad])
        if (corner != a && corner != b && corner != c && corner != d &&
            std::find(around_a.begin(), around_a.end(), corner) != around_a.end())
          return false;
    }
    return shared_quads == 1;
  }

  void removeUnused() {
    std::vector<int> new_index(net_.points.size(), -1);
    QuadNet kept;
    for (std::size_t p = 0; p < net_.points.size(); ++p) {
      if (quads_of_point_[p].empty()) continue;
      new_index[p] = int(kept.points.size());
      kept.points.push_back(net_.points[p]);
      kept.features.push_back(net_.features[p]);
    }
    for (std::size_t q = 0; q < net_.quads.size(); ++q) {
      if (!alive_[q]) continue;
      kept.quads.push_back(net_.quads[q]);
      for (int& corner : kept.quads.back()) corner = new_index[corner];
    }
    net_ = std::move(kept);
  }

  QuadNet& net_;
  std::vector<std::vector<int>> quads_of_point_;
  std::vector<char> alive_;
};

}  // namespace

void collapseRhombi(QuadNet& net) {
  Collapser(net).run();
}

}  // namespace airclay
