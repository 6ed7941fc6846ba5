#include "pipeline/keyframes/key_heart.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>

#include "pipeline/core/parallel.h"
#include "pipeline/field/closest_triangle.h"
#include "pipeline/field/surface_rows.h"
#include "pipeline/keyframes/bounded_spline.h"
#include "runtime/base/error.h"

namespace beatlas::keyframes {
namespace {

using field::TriangleSoup;
using Distances = std::vector<float>;  // of every voxel [mm], negative inside

constexpr double kMarginMm = 8;
constexpr double kMostVoxels = 3e8;
constexpr float kOutside = 80;  // signals; any would do that differ
constexpr float kMuscle = 400;
constexpr float kBlood = 1000;

std::size_t at(int n) { return static_cast<std::size_t>(n); }

std::string told(Structure structure, std::size_t key) {
  return "key surface " + std::to_string(key + 1) + " of " + std::string(structure_name(structure));
}

// Every edge lies between two triangles that run along it in opposite directions.
void check_closed(const TriangleSoup& surface, const std::string& name) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& triangle : surface.triangles) {
    for (std::size_t n = 0; n < 3; ++n) {
      const std::uint32_t a = triangle[n];
      const std::uint32_t b = triangle[(n + 1) % 3];
      if (a >= surface.points.size()) throw_invalid(name + " has a corner that is not there");
      ++edges[{a, b}];
    }
  }
  for (const Vec3& point : surface.points) {
    if (!point.allFinite()) throw_invalid(name + " has a corner that is no place");
  }
  std::size_t open = 0;
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (back == edges.end() || back->second != count) ++open;
  }
  if (surface.triangles.empty()) throw_invalid(name + " has no triangles");
  if (open > 0) {
    throw_invalid(name + " is not closed: " + std::to_string(open) +
                  " edges have no triangle on their other side; close it in a mesh editor");
  }
}

void check(const KeyHeart& heart) {
  if (!(heart.rr_interval_s >= 0.02 && heart.rr_interval_s <= 20)) {
    throw_invalid("the R-R interval must be from 0.02 to 20 s");
  }
  if (heart.phases < 3 || heart.phases > 200) throw_invalid("phases must be from 3 to 200");
  if (!(heart.voxel_mm >= 0.3 && heart.voxel_mm <= 5)) {
    throw_invalid("voxels must be from 0.3 to 5 mm");
  }
  if (heart.surfaces.count(Structure::Heart) == 0) {
    throw_invalid("there is no key surface of heart, its outside");
  }
  for (const auto& [structure, keys] : heart.surfaces) {
    if (structure != Structure::Heart && structure != Structure::LvBlood &&
        structure != Structure::RvBlood && structure != Structure::LvMyocardium) {
      throw_invalid("key surfaces of " + std::string(structure_name(structure)) +
                    " are not understood; there are heart, lv_blood, rv_blood and lv_myocardium");
    }
    if (keys.size() != heart.key_at.size()) {
      throw_invalid(std::string(structure_name(structure)) + " has " + std::to_string(keys.size()) +
                    " key surfaces for " + std::to_string(heart.key_at.size()) + " moments");
    }
    for (std::size_t key = 0; key < keys.size(); ++key) {
      check_closed(keys[key], told(structure, key));
    }
  }
}

// Then the points of the keys are blended; otherwise distances of every voxel are, a set a key.
bool share_triangles(const std::vector<TriangleSoup>& keys) {
  return std::all_of(keys.begin(), keys.end(), [&](const TriangleSoup& key) {
    return key.triangles == keys.front().triangles &&
           key.points.size() == keys.front().points.size();
  });
}

Grid grid_of(const KeyHeart& heart) {
  Eigen::AlignedBox3d box;
  for (const auto& [structure, keys] : heart.surfaces) {
    for (const TriangleSoup& key : keys) {
      for (const Vec3& point : key.points) box.extend(point);
    }
  }
  std::size_t images = static_cast<std::size_t>(heart.phases);
  for (const auto& [structure, keys] : heart.surfaces) {
    images += share_triangles(keys) ? 0 : keys.size();
  }
  const Vec3 size = (box.sizes() + Vec3::Constant(2 * kMarginMm)) / heart.voxel_mm;
  if (!(size.prod() * static_cast<double>(images) <= kMostVoxels)) {
    throw_invalid(
        "the images, and distances of keys that do not share their triangles, would have more than "
        "3e8 voxels; give larger voxels, or surfaces in mm");
  }
  Grid grid;
  for (std::size_t a = 0; a < 3; ++a) {
    grid.size[a] = static_cast<int>(std::ceil(size[static_cast<Eigen::Index>(a)])) + 1;
  }
  grid.mm_from_index =
      Eigen::Translation3d(box.min() - Vec3::Constant(kMarginMm)) * Eigen::Scaling(heart.voxel_mm);
  return grid;
}

// Signed distance at every voxel, no larger than most_mm.
Distances distances(const TriangleSoup& surface, const Grid& grid, double most_mm) {
  const field::ClosestTriangle tree(surface);
  const auto rows = field::row_crossings(surface, grid);
  Distances out(grid.count());
  parallel_for(at(grid.size[2]), [&](std::size_t slice) {
    const int k = static_cast<int>(slice);
    for (int j = 0; j < grid.size[1]; ++j) {
      const std::vector<double>& row = rows[at(j) + at(grid.size[1]) * slice];
      std::size_t passed = 0;
      field::ClosestTriangle::Hit found;
      for (int i = 0; i < grid.size[0]; ++i) {
        while (passed < row.size() && row[passed] <= i) ++passed;
        field::ClosestTriangle::Hit bound;
        bound.distance2_mm2 = most_mm * most_mm;
        // What is nearest to a voxel is near to the next one: little else has to be looked at.
        const Vec3 place = grid.mm(i, j, k);
        if (found.four != field::ClosestTriangle::Hit().four) {
          bound = tree.nearest_of(found.four, place, bound);
        }
        found = tree.nearest(place, bound);
        const double mm = std::sqrt(found.distance2_mm2);
        out[grid.offset(i, j, k)] = static_cast<float>(passed % 2 == 1 ? -mm : mm);
      }
    }
  });
  return out;
}

// One structure at any moment of the cycle.
class Moving {
 public:
  Moving(const std::vector<TriangleSoup>& keys, const Grid& grid, double near_mm)
      : keys_(keys), grid_(grid), near_mm_(near_mm) {
    shared_ = share_triangles(keys);
    if (shared_) return;
    for (const TriangleSoup& key : keys) keys_ml_.push_back(field::enclosed_ml(key));
    const double far_mm = std::numeric_limits<double>::infinity();
    for (std::size_t n = 0; n < keys.size(); ++n) {
      // A relaxation that is the contraction backwards has each key twice.
      std::size_t same = 0;
      while (keys[same].points != keys[n].points || keys[same].triangles != keys[n].triangles) {
        ++same;
      }
      at_keys_.push_back(same < n ? at_keys_[same]
                                  : std::make_shared<Distances>(distances(keys[n], grid, far_mm)));
    }
  }

  [[nodiscard]] Distances at_weights(const Eigen::VectorXd& weights) const {
    if (shared_) return distances(blended(weights), grid_, near_mm_);
    Distances out(grid_.count(), 0.0F);
    for (std::size_t n = 0; n < at_keys_.size(); ++n) {
      const auto weight = static_cast<float>(weights[static_cast<Eigen::Index>(n)]);
      for (std::size_t v = 0; v < out.size(); ++v) out[v] += weight * (*at_keys_[n])[v];
    }
    return out;
  }

  /// Where distances are blended, volumes are taken to be, too: so small is the change from key to
  /// key that they fit for.
  [[nodiscard]] double ml_at_weights(const Eigen::VectorXd& weights) const {
    if (shared_) return field::enclosed_ml(blended(weights));
    double ml = 0;
    for (std::size_t n = 0; n < keys_ml_.size(); ++n) {
      ml += weights[static_cast<Eigen::Index>(n)] * keys_ml_[n];
    }
    return ml;
  }

 private:
  [[nodiscard]] TriangleSoup blended(const Eigen::VectorXd& weights) const {
    TriangleSoup now = keys_.front();
    for (std::size_t p = 0; p < now.points.size(); ++p) {
      now.points[p].setZero();
      for (std::size_t n = 0; n < keys_.size(); ++n) {
        now.points[p] += weights[static_cast<Eigen::Index>(n)] * keys_[n].points[p];
      }
    }
    return now;
  }

  const std::vector<TriangleSoup>& keys_;
  const Grid& grid_;
  double near_mm_;
  bool shared_ = false;
  std::vector<std::shared_ptr<const Distances>> at_keys_;
  std::vector<double> keys_ml_;
};

// All structures at one moment.
class Moment {
 public:
  Moment(const std::map<Structure, Moving>& moving, const Eigen::VectorXd& weights, double voxel_mm)
      : voxel_mm_(static_cast<float>(voxel_mm)) {
    for (const auto& [structure, surface] : moving) {
      distances_.emplace(structure, surface.at_weights(weights));
    }
  }

  [[nodiscard]] float signal(std::size_t voxel) const {
    const float blood =
        std::max(covered(Structure::LvBlood, voxel), covered(Structure::RvBlood, voxel));
    const float body = covered(Structure::Heart, voxel);
    return (1 - blood) * (kOutside + (kMuscle - kOutside) * body) + blood * kBlood;
  }

  /// @param rest what of the heart none of the others fills
  [[nodiscard]] std::uint8_t label(std::size_t voxel, std::uint8_t rest) const {
    if (inside(Structure::LvBlood, voxel)) return kLabelLvBlood;
    if (inside(Structure::RvBlood, voxel)) return kLabelRvBlood;
    if (inside(Structure::LvMyocardium, voxel)) return kLabelLvMyocardium;
    if (inside(Structure::Heart, voxel)) return rest;
    return kLabelBackground;
  }

 private:
  [[nodiscard]] bool inside(Structure structure, std::size_t voxel) const {
    const auto found = distances_.find(structure);
    return found != distances_.end() && found->second[voxel] < 0;
  }

  [[nodiscard]] float covered(Structure structure, std::size_t voxel) const {
    const auto found = distances_.find(structure);
    if (found == distances_.end()) return 0.0F;
    return std::clamp(0.5F - found->second[voxel] / voxel_mm_, 0.0F, 1.0F);
  }

  float voxel_mm_;
  std::map<Structure, Distances> distances_;
};

}  // namespace

SeenHeart see_heart(const KeyHeart& heart, StageContext& context) {
  check(heart);
  SeenHeart out;
  Cine& stack = out.exam.stack;
  const Grid grid = grid_of(heart);
  stack.images.grid = grid;
  stack.rr_interval_s = heart.rr_interval_s;
  out.labels.grid = grid;
  std::map<Structure, Moving> moving;
  for (const auto& [structure, keys] : heart.surfaces) {
    moving.try_emplace(structure, keys, grid, 2 * heart.voxel_mm);
  }
  std::vector<VolumeOf> volumes;
  for (const auto& [structure, surface] : moving) {
    volumes.emplace_back([&one = surface](const Eigen::VectorXd& weights) {
      return std::abs(one.ml_at_weights(weights));
    });
  }
  const BoundedSpline bounded = bounded_spline(heart.key_at, volumes);
  const bool rest_is_muscle = heart.surfaces.count(Structure::RvBlood) == 0 &&
                              heart.surfaces.count(Structure::LvMyocardium) == 0;
  const std::uint8_t rest = rest_is_muscle ? kLabelLvMyocardium : kLabelRestOfHeart;
  for (int phase = 0; phase < heart.phases; ++phase) {
    context.check_cancelled();
    const double share = static_cast<double>(phase) / heart.phases;
    stack.frame_times_s.push_back(share * heart.rr_interval_s);
    const Moment now(moving, bounded.spline.weights(share), heart.voxel_mm);
    std::vector<float>& image = stack.images.phases.emplace_back(grid.count());
    std::vector<std::uint8_t>& labels = out.labels.phases.emplace_back(grid.count());
    for (std::size_t voxel = 0; voxel < grid.count(); ++voxel) {
      image[voxel] = now.signal(voxel);
      labels[voxel] = now.label(voxel, rest);
    }
    context.progress((phase + 1.0) / heart.phases);
  }
  out.exam.source_format = "surfaces";
  out.exam.decisions.push_back("The images are made from " + std::to_string(heart.key_at.size()) +
                               " key moments, " + std::to_string(heart.phases) +
                               " phases by a periodic cubic spline; they come from no scanner.");
  if (!bounded.held.empty()) {
    out.exam.decisions.push_back(
        "Key moments are so uneven that volumes would overshoot between them: at " +
        std::to_string(bounded.held.size()) +
        " of them the spline is smooth in velocity alone, not in acceleration.");
  }
  return out;
}

}  // namespace beatlas::keyframes
