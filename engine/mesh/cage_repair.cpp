// SPDX-License-Identifier: MIT
// Welds on a grid of cells, orients faces by a union-find with parity, and finds fans of faces by a
// union-find over their corners.
#include "engine/mesh/cage_repair.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "engine/core/task.h"

namespace airclay {
namespace {

constexpr double kWeldFraction = 1e-6;      // of the bounding box's longest side
constexpr std::size_t kListedPlaces = 10;   // in a message
constexpr std::size_t kComparedHulls = 64;  // parts that may have cavities: bounds the comparisons
constexpr std::size_t kListedFaces = 4;     // in a place

std::string counted(std::size_t count, const std::string& thing) {
  const bool is_vertex = thing == "vertex";
  return std::to_string(count) + " " + (count == 1 ? thing : is_vertex ? "vertices" : thing + "s");
}

std::string text(const Vec3& point) {
  char line[96];
  std::snprintf(line, sizeof line, "(%.6g, %.6g, %.6g)", point.x(), point.y(), point.z());
  return line;
}

/// One kind of problem and the first places where it occurs.
class Problem {
 public:
  /// `place` is called only if its text will be listed.
  template <typename Place>
  void add(Place place) {
    if (count_++ < kListedPlaces) places_.push_back(place());
  }
  /// "`what`: place; place; and 3 more"
  void report(const std::string& what_one, const std::string& what_many,
              std::vector<std::string>& problems) const {
    if (count_ == 0) return;
    std::string line = std::to_string(count_) + " " + (count_ == 1 ? what_one : what_many) + ": ";
    for (std::size_t i = 0; i < places_.size(); ++i) line += (i == 0 ? "" : "; ") + places_[i];
    if (count_ > places_.size()) line += "; and " + std::to_string(count_ - places_.size()) + " more";
    problems.push_back(line);
  }

 private:
  std::size_t count_ = 0;
  std::vector<std::string> places_;
};

/// Disjoint sets whose members are equal or opposite to their set's root (Tarjan's union-find, path halving).
class ParitySets {
 public:
  explicit ParitySets(std::size_t count) : parent_(count), opposite_(count, false) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  struct Root {
    int index;
    bool opposite;
  };
  Root find(int member) {
    bool opposite = false;
    while (parent_[std::size_t(member)] != member) {
      const std::size_t at = std::size_t(member), up = std::size_t(parent_[at]);
      opposite_[at] = opposite_[at] != opposite_[up];  // false for a root
      parent_[at] = parent_[up];
      opposite = opposite != opposite_[at];
      member = parent_[at];
    }
    return {member, opposite};
  }
  /// False if the opposite relation is already known.
  bool join(int a, int b, bool opposite = false) {
    const Root of_a = find(a), of_b = find(b);
    if (of_a.index == of_b.index) return (of_a.opposite != of_b.opposite) == opposite;
    // The smaller index becomes the root: the first face of a part.
    const auto [root, child] = std::minmax(of_a.index, of_b.index);
    parent_[std::size_t(child)] = root;
    opposite_[std::size_t(child)] = (of_a.opposite != of_b.opposite) != opposite;
    return true;
  }

 private:
  std::vector<int> parent_;
  std::vector<bool> opposite_;  ///< relative to the parent
};

/// A face's directed edge.
struct Side {
  int low, high;  ///< the points, low < high
  int face;
  bool is_forward;              ///< runs from low to high
  int low_corner, high_corner;  ///< counted over all faces

  bool sameEdge(const Side& other) const { return low == other.low && high == other.high; }
};

bool operator<(const Side& a, const Side& b) {
  if (a.low != b.low) return a.low < b.low;
  return a.high != b.high ? a.high < b.high : a.face < b.face;
}

/// Faces connected by edges.
struct Part {
  std::size_t faces = 0, opposite_faces = 0;  ///< opposite to the part's first face
  bool is_closed = true, is_one_sided = false;
  double volume = 0;  ///< six times the signed volume, by the first face's winding
  Eigen::AlignedBox3d box;
};

class CageRepair {
 public:
  explicit CageRepair(MeshSource source)
      : points_(std::move(source.points)),
        faces_(std::move(source.faces)),
        lines_(std::move(source.face_lines)),
        broken_(faces_.size(), false) {
    reading_.repairs = std::move(source.notes);
    dropLoose(source.loose_edges);
    weld();
    removeRepeatedCorners();
    findFlatFaces();
    findDuplicates();
    sides_ = sortedSides();
    joinFaces();
    orient();
  }

  CageReading take() {
    reading_.cage = {std::move(points_), std::move(faces_)};
    return std::move(reading_);
  }

 private:
  std::string place(std::size_t face) const {
    return lines_.empty() ? "face " + std::to_string(face + 1) : "line " + std::to_string(lines_[face]);
  }

  Eigen::AlignedBox3d bounds() const {
    Eigen::AlignedBox3d box;
    for (const Vec3& point : points_) box.extend(point);
    return box;
  }

  /// Replaces each point p by `target[p]`; removes points that are not their own target.
  void mergePoints(const std::vector<int>& target) {
    std::vector<int> place(points_.size());
    std::size_t count = 0;
    for (std::size_t p = 0; p < points_.size(); ++p)
      if (target[p] == int(p)) {
        place[p] = int(count);
        points_[count++] = points_[p];
      }
    points_.resize(count);
    for (std::vector<int>& face : faces_)
      for (int& corner : face) corner = place[std::size_t(target[std::size_t(corner)])];
  }

  void dropLoose(std::size_t loose_edges) {
    std::vector<int> target(points_.size(), -1);
    for (const std::vector<int>& face : faces_)
      for (const int corner : face) target[std::size_t(corner)] = corner;
    const std::size_t loose = std::size_t(std::count(target.begin(), target.end(), -1));
    if (loose > 0) mergePoints(target);
    if (loose + loose_edges == 0) return;
    const std::string vertices = loose > 0 ? counted(loose, "vertex") : "";
    const std::string edges = loose_edges > 0 ? counted(loose_edges, "edge") : "";
    reading_.repairs.push_back("dropped " + vertices + (loose > 0 && loose_edges > 0 ? " and " : "") + edges +
                               " without a face");
  }

  /// Merges every point into the first one within the tolerance.
  void weld() {
    const Eigen::AlignedBox3d box = bounds();
    tolerance_ = kWeldFraction * box.sizes().maxCoeff();
    // Cells are far larger than the tolerance, so that most points search only one.
    const double cell = tolerance_ > 0 ? 16 * tolerance_ : 1;
    const auto cellOf = [&](double from_corner) { return std::int64_t(std::floor(from_corner / cell)); };
    const auto key = [](std::int64_t x, std::int64_t y, std::int64_t z) {
      return (std::uint64_t(x + 1) << 42) | (std::uint64_t(y + 1) << 21) |
             std::uint64_t(z + 1);  // below 2^17
    };
    std::unordered_map<std::uint64_t, int> last_in_cell;
    std::vector<int> previous_in_cell(points_.size(), -1), target(points_.size());
    std::size_t welded = 0;
    for (std::size_t p = 0; p < points_.size(); ++p) {
      reportProgress(p, points_.size());
      const Vec3 at = points_[p] - box.min();
      std::array<std::int64_t, 3> low{}, high{};
      for (int axis = 0; axis < 3; ++axis) {
        low[std::size_t(axis)] = cellOf(at[axis] - tolerance_);
        high[std::size_t(axis)] = cellOf(at[axis] + tolerance_);
      }
      int first = int(p);
      for (std::int64_t x = low[0]; x <= high[0]; ++x)
        for (std::int64_t y = low[1]; y <= high[1]; ++y)
          for (std::int64_t z = low[2]; z <= high[2]; ++z) {
            const auto found = last_in_cell.find(key(x, y, z));
            for (int q = found == last_in_cell.end() ? -1 : found->second; q >= 0;
                 q = previous_in_cell[std::size_t(q)])
              if ((points_[std::size_t(q)] - points_[p]).norm() <= tolerance_) first = std::min(first, q);
          }
      target[p] = first;
      if (first == int(p)) {
        const auto [cell_entry, is_new] =
            last_in_cell.try_emplace(key(cellOf(at.x()), cellOf(at.y()), cellOf(at.z())), int(p));
        if (!is_new) previous_in_cell[p] = std::exchange(cell_entry->second, int(p));
      } else {
        ++welded;
      }
    }
    if (welded == 0) return;
    mergePoints(target);
    reading_.repairs.push_back(
        "welded " + counted(welded, "vertex") + " to others at the same place (within 1e-6 of the size), " +
        std::to_string(points_.size()) + (points_.size() == 1 ? " remains" : " remain"));
  }

  void removeRepeatedCorners() {
    std::size_t repaired = 0;
    for (std::vector<int>& face : faces_) {
      const std::size_t before = face.size();
      face.erase(std::unique(face.begin(), face.end()), face.end());
      while (face.size() > 1 && face.front() == face.back()) face.pop_back();
      repaired += before != face.size() && face.size() >= 3;
    }
    if (repaired > 0)
      reading_.repairs.push_back("removed corners that repeat the previous one from " +
                                 counted(repaired, "face"));
  }

  bool isFlat(const std::vector<int>& face) const {
    if (face.size() < 3) return true;
    Vec3 twice_area = Vec3::Zero();
    double longest = 0;
    const Vec3& first = points_[std::size_t(face[0])];
    for (std::size_t k = 0; k < face.size(); ++k) {
      const Vec3& from = points_[std::size_t(face[k])];
      const Vec3& to = points_[std::size_t(face[(k + 1) % face.size()])];
      twice_area += (from - first).cross(to - first);
      longest = std::max(longest, (to - from).norm());
    }
    return twice_area.norm() <= tolerance_ * longest;
  }

  void findFlatFaces() {
    Problem flat, crossed;
    std::vector<int> sorted;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      sorted = faces_[f];
      std::sort(sorted.begin(), sorted.end());
      const bool uses_twice = std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
      broken_[f] = faces_[f].size() < 3 || uses_twice;
      if (isFlat(faces_[f]))
        flat.add([&] { return place(f) + " at " + text(points_[std::size_t(faces_[f][0])]); });
      else if (uses_twice)
        crossed.add([&] { return place(f) + " at " + text(points_[std::size_t(faces_[f][0])]); });
    }
    flat.report("face has no area", "faces have no area", reading_.problems);
    crossed.report("face uses a vertex twice", "faces use a vertex twice", reading_.problems);
  }

  /// Faces with the same corners, in any order.
  void findDuplicates() {
    std::vector<std::size_t> hashes(faces_.size());
    std::vector<std::size_t> order;
    order.reserve(faces_.size());
    const auto sortedCorners = [&](std::size_t f) {
      std::vector<int> corners = faces_[f];
      std::sort(corners.begin(), corners.end());
      return corners;
    };
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (broken_[f]) continue;
      std::size_t hash = faces_[f].size();
      for (const int corner : faces_[f]) {  // a sum does not depend on the order
        const std::uint64_t mixed = (std::uint64_t(corner) + 1) * 0x9E3779B97F4A7C15u;
        hash += std::size_t(mixed ^ (mixed >> 29)) * 0xBF58476D1CE4E5B9u;
      }
      hashes[f] = hash;
      order.push_back(f);
    }
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return hashes[a] != hashes[b] ? hashes[a] < hashes[b] : a < b;
    });
    std::vector<std::pair<std::size_t, std::size_t>> repeats;  // the later face, the first one
    for (std::size_t i = 1, first = 0; i < order.size(); ++i) {
      if (hashes[order[i]] != hashes[order[first]]) first = i;
      if (first == i || sortedCorners(order[i]) != sortedCorners(order[first])) continue;
      repeats.emplace_back(order[i], order[first]);
    }
    std::sort(repeats.begin(), repeats.end());
    Problem duplicates;
    for (const auto& [face, first] : repeats) {
      broken_[face] = true;
      duplicates.add(
          [&, later = face, earlier = first] { return place(later) + " repeats " + place(earlier); });
    }
    duplicates.report("face has the corners of another", "faces have the corners of another",
                      reading_.problems);
  }

  /// Of all faces that are not broken.
  std::vector<Side> sortedSides() const {
    std::vector<Side> sides;
    int first_corner = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      const std::vector<int>& face = faces_[f];
      const int size = int(face.size());
      for (int k = 0; k < size && !broken_[f]; ++k) {
        const int next = (k + 1) % size, from = face[std::size_t(k)], to = face[std::size_t(next)];
        if (from < to)
          sides.push_back({from, to, int(f), true, first_corner + k, first_corner + next});
        else
          sides.push_back({to, from, int(f), false, first_corner + next, first_corner + k});
      }
      first_corner += size;
    }
    std::sort(sides.begin(), sides.end());
    return sides;
  }

  std::string edgeText(const Side& side) const {
    return text(points_[std::size_t(side.low)]) + " to " + text(points_[std::size_t(side.high)]);
  }

  std::string edgePlace(std::size_t first, std::size_t end) const {
    std::string faces;
    for (std::size_t i = first; i < end && i < first + kListedFaces; ++i)
      faces += (i == first ? "" : ", ") + place(std::size_t(sides_[i].face));
    return edgeText(sides_[first]) + " (" + faces + (end - first > kListedFaces ? ", …)" : ")");
  }

  /// Relates the two faces of every edge, and collects edges with more and points where fans touch.
  void joinFaces() {
    std::size_t corner_count = 0;
    for (const std::vector<int>& face : faces_) corner_count += face.size();
    parts_.emplace(faces_.size());
    open_.assign(faces_.size(), false);
    twisted_.assign(faces_.size(), nullptr);
    ParitySets fans(corner_count);
    std::vector<bool> is_crowded(points_.size(), false);  // at an end of an edge with more than two faces
    Problem crowded;
    for (std::size_t i = 0, end = 0; i < sides_.size(); i = end) {
      reportProgress(i, sides_.size());
      for (end = i + 1; end < sides_.size() && sides_[end].sameEdge(sides_[i]);) ++end;
      const Side &a = sides_[i], &b = sides_[end - 1];
      if (end - i == 1) {
        open_[std::size_t(a.face)] = true;
      } else if (end - i == 2) {
        if (!parts_->join(a.face, b.face, a.is_forward == b.is_forward)) twisted_[std::size_t(a.face)] = &a;
        fans.join(a.low_corner, b.low_corner);
        fans.join(a.high_corner, b.high_corner);
      } else {
        is_crowded[std::size_t(a.low)] = is_crowded[std::size_t(a.high)] = true;
        crowded.add([&] { return edgePlace(i, end); });
      }
    }
    crowded.report("edge has more than two faces", "edges have more than two faces", reading_.problems);
    findTouchingFans(fans, is_crowded);
  }

  void findTouchingFans(ParitySets& fans, const std::vector<bool>& is_crowded) {
    std::vector<int> fan_of_point(points_.size(), -1);
    std::vector<bool> touches(points_.size(), false);
    int corner_index = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f)
      for (const int corner : faces_[f]) {
        const int fan = fans.find(corner_index++).index;
        int& known = fan_of_point[std::size_t(corner)];
        if (broken_[f]) continue;
        if (known >= 0 && known != fan) touches[std::size_t(corner)] = !is_crowded[std::size_t(corner)];
        known = fan;
      }
    Problem touching;
    for (std::size_t p = 0; p < points_.size(); ++p)
      if (touches[p]) touching.add([&] { return text(points_[p]); });
    touching.report("vertex joins faces that share no edge there (a bow tie)",
                    "vertices join faces that share no edge there (bow ties)", reading_.problems);
  }

  double sixfoldVolume(const std::vector<int>& face, const Vec3& origin) const {
    double volume = 0;
    const Vec3 a = points_[std::size_t(face[0])] - origin;
    for (std::size_t k = 2; k < face.size(); ++k)
      volume +=
          a.dot((points_[std::size_t(face[k - 1])] - origin).cross(points_[std::size_t(face[k])] - origin));
    return volume;
  }

  /// The parts by the index of their first face.
  std::unordered_map<int, Part> measuredParts() {
    std::unordered_map<int, Part> parts;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (broken_[f]) continue;
      const auto [first, opposite] = parts_->find(int(f));
      Part& part = parts[first];
      ++part.faces;
      part.opposite_faces += opposite;
      part.is_closed = part.is_closed && !open_[f];
      part.is_one_sided = part.is_one_sided || twisted_[f];
      const Vec3& origin = points_[std::size_t(faces_[std::size_t(first)][0])];  // near: keeps digits
      part.volume += (opposite ? -1 : 1) * sixfoldVolume(faces_[f], origin);
      for (const int corner : faces_[f]) part.box.extend(points_[std::size_t(corner)]);
    }
    return parts;
  }

  /// Whether the faces of `part` that agree with its first face have to be flipped.
  static bool isFlipped(const Part& part, const std::vector<const Part*>& hulls) {
    const bool by_majority = 2 * part.opposite_faces > part.faces;
    const double negligible = kWeldFraction * part.box.volume();
    if (!part.is_closed || std::abs(part.volume) <= negligible) return by_majority;
    // A part inside another closed one may be a cavity, which faces inwards.
    for (const Part* hull : hulls)
      if (hull != &part && hull->box.contains(part.box)) return by_majority;
    return part.volume < 0;
  }

  /// The closed parts with the largest boxes.
  static std::vector<const Part*> largestClosed(const std::unordered_map<int, Part>& parts) {
    std::vector<const Part*> closed;
    for (const auto& [first, part] : parts)
      if (part.is_closed) closed.push_back(&part);
    const std::size_t count = std::min(closed.size(), kComparedHulls);
    std::partial_sort(closed.begin(), closed.begin() + std::ptrdiff_t(count), closed.end(),
                      [](const Part* a, const Part* b) { return a->box.volume() > b->box.volume(); });
    closed.resize(count);
    return closed;
  }

  void orient() {
    const std::unordered_map<int, Part> parts = measuredParts();
    const std::vector<const Part*> hulls = largestClosed(parts);
    std::unordered_map<int, bool> flipped;
    Problem one_sided;
    reading_.is_closed = true;
    for (const auto& [first, part] : parts) {
      flipped[first] = isFlipped(part, hulls);
      reading_.is_closed = reading_.is_closed && part.is_closed;
    }
    std::vector<bool> is_reported(faces_.size(), false);
    std::size_t flipped_count = 0;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (broken_[f]) continue;
      const auto [first, opposite] = parts_->find(int(f));
      if (twisted_[f] && !is_reported[std::size_t(first)]) {
        is_reported[std::size_t(first)] = true;
        one_sided.add([&] { return edgeText(*twisted_[f]); });
      }
      if (parts.at(first).is_one_sided || flipped.at(first) == opposite) continue;
      std::reverse(faces_[f].begin() + 1, faces_[f].end());
      ++flipped_count;
    }
    one_sided.report("part has one side only, as a Möbius strip; its winding breaks at",
                     "parts have one side only, as a Möbius strip; their winding breaks at",
                     reading_.problems);
    if (flipped_count > 0)
      reading_.repairs.push_back(
          "flipped " + std::to_string(flipped_count) + " of " + counted(faces_.size(), "face") +
          (reading_.is_closed ? " to face outwards" : " to agree with their neighbours"));
  }

  std::vector<Vec3> points_;
  std::vector<std::vector<int>> faces_;
  std::vector<long> lines_;
  std::vector<bool> broken_;  ///< per face: without a meaning for its neighbours
  double tolerance_ = 0;
  std::vector<Side> sides_;
  std::optional<ParitySets> parts_;   ///< faces joined by edges
  std::vector<bool> open_;            ///< per face: with an edge of its own alone
  std::vector<const Side*> twisted_;  ///< per face: a side where the winding cannot agree
  CageReading reading_;
};

}  // namespace

CageReading repairCage(MeshSource source) {
  return CageRepair(std::move(source)).take();
}

}  // namespace airclay
