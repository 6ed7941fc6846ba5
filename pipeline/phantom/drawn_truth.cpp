#include "pipeline/phantom/drawn_truth.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/drawn_exam.h"
#include "pipeline/phantom/drawn_slices.h"
#include "pipeline/phantom/drawn_stack.h"
#include "runtime/base/json_object.h"

namespace beatlas::phantom {
namespace {

constexpr float kHalvedMm = 0.01F;
constexpr int kVolumePerEdge = 4;  ///< as of the volumes in truth.json
constexpr int kNormalCells = 2;    ///< about a crossing that tell its normal

double structure_ml(const std::array<double, 8>& by_label, Structure structure) {
  double out = 0;
  for (std::uint8_t label = 1; label <= kLastLabel; ++label) {
    if (label_in_structure(label, structure)) out += by_label.at(label);
  }
  return out;
}

std::map<Structure, std::vector<double>> volumes_of(const nlohmann::json& structures,
                                                    std::size_t phases) {
  std::map<Structure, std::vector<double>> out;
  if (!structures.is_array()) throw_invalid("/structures must be a list");
  for (const nlohmann::json& entry : structures) {
    JsonObject object(entry, "/structures");
    std::string name;
    object.read("name", name);
    const std::optional<Structure> structure = structure_from_name(name);
    if (!structure) throw_invalid("/structures: there is no structure \"" + name + "\"");
    std::vector<double>& curve = out[*structure];
    object.read("volume_ml", curve, 0, 1e5);
    if (curve.size() != phases) {
      throw_invalid("/structures: " + name + " needs a volume for each of /contraction");
    }
  }
  for (const Structure structure : kAllStructures) {
    if (!out.contains(structure)) {
      throw_invalid("/structures lack " + std::string(structure_name(structure)));
    }
  }
  return out;
}

}  // namespace

bool is_drawn_truth(const nlohmann::json& truth) {
  if (!truth.is_object()) return false;
  const auto format = truth.find("format");
  return format != truth.end() && *format == kDrawnTruthFormat;
}

DrawnTruth::DrawnTruth(const nlohmann::json& truth) {
  JsonObject object(truth, "");
  std::string format;
  object.read("format", format);
  if (format != kDrawnTruthFormat) {
    throw_invalid("/format must be \"" + std::string(kDrawnTruthFormat) +
                  "\": this is no truth of a drawn exam");
  }
  int version = 0;
  object.read("version", version, 1, 1000000);
  if (version != kDrawnTruthVersion) {
    throw_invalid("/version must be " + std::to_string(kDrawnTruthVersion) +
                  ": this truth was written by another version of beatlas");
  }
  bool has_heart = false;
  object.read("has_heart", has_heart);
  if (!has_heart) throw_invalid("/has_heart is false: of a body without a heart no atlas is made");
  int seed = -1;
  int attempt = -1;
  object.read("seed", seed, 0, static_cast<int>(kMostDrawSeed));
  object.read("attempt", attempt, 0, static_cast<int>(kMostDrawAttempts) - 1);
  if (seed < 0 || attempt < 0) throw_invalid("/seed and /attempt must be there");
  object.read("identity", identity_);
  object.read("rr_interval_s", rr_interval_s_, 0.01, 100);
  object.read("contraction", contraction_, 0, 1);
  if (contraction_.empty()) throw_invalid("/contraction is empty: it has a number a phase");
  const Family family =
      exam_family(static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(attempt));
  heart_.emplace(family);
  axes_ = heart_axes(family);
  // Neither planes nor breath-holds hang on the number of voxels.
  const DrawnStack stack = drawn_stack(family, *heart_, axes_, DrawnExamOptions().most_voxels);
  for (const Eigen::Vector2f& shift : stack.shifts) {
    moved_mm_ += (shift.x() * stack.u + shift.y() * stack.v) / static_cast<float>(stack.slices);
  }
  volume_ml_ = volumes_of(object.at("structures"), contraction_.size());
  // The family's laws are in the program, so ask whether it still draws the same heart.
  const std::array<double, 8> mine =
      drawn_volumes_ml(*heart_, static_cast<float>(contraction_[0]), kVolumePerEdge);
  for (const auto& [structure, curve] : volume_ml_) {
    if (std::abs(curve[0] - structure_ml(mine, structure)) < 1e-4) continue;
    throw_invalid(
        "/structures differ from the heart of /seed: the truth was changed, or written by a "
        "version "
        "of beatlas with another family");
  }
}

double DrawnTruth::volume_ml(Structure structure, int phase) const {
  return volume_ml_.at(structure).at(static_cast<std::size_t>(phase));
}

DrawnTruth::Frame DrawnTruth::frame(int phase, double spacing_mm) const {
  return {*this, static_cast<float>(contraction_.at(static_cast<std::size_t>(phase))), spacing_mm};
}

DrawnTruth::Frame::Frame(const DrawnTruth& truth, float contraction, double spacing_mm)
    : truth_(truth), moment_(truth.heart_->moment(contraction)), spacing_mm_(spacing_mm) {
  const auto step = static_cast<float>(spacing_mm);
  const int half = static_cast<int>(truth.heart_->reach() / step) + 1 + kNormalCells;
  across_ = 2 * half + 1;
  corner_ = truth.heart_->middle() - Vec3F::Constant(step * static_cast<float>(half));
  const auto layer = static_cast<std::size_t>(across_) * static_cast<std::size_t>(across_);
  labels_.resize(layer * static_cast<std::size_t>(across_));
  parallel_for(static_cast<std::size_t>(across_), [&](std::size_t k) {
    std::size_t at = k * layer;
    for (int j = 0; j < across_; ++j) {
      for (int i = 0; i < across_; ++i, ++at) {
        labels_[at] = label_at(place({i, j, static_cast<int>(k)}));
      }
    }
  });
}

Vec3F DrawnTruth::Frame::in_heart(const Vec3& lps) const {
  return truth_.axes_.transpose() * (lps.cast<float>() - truth_.moved_mm_) +
         truth_.heart_->middle();
}

std::uint8_t DrawnTruth::Frame::label_at(const Vec3F& place) const {
  const DrawnHeart& heart = *truth_.heart_;
  if ((place - heart.middle()).norm() > heart.reach()) return kLabelBackground;
  return phantom::label_of(heart.at(place, moment_));
}

Vec3F DrawnTruth::Frame::place(const Index3& index) const {
  return corner_ + static_cast<float>(spacing_mm_) * Vec3F(static_cast<float>(index[0]),
                                                           static_cast<float>(index[1]),
                                                           static_cast<float>(index[2]));
}

bool DrawnTruth::Frame::holds(Structure structure, const Index3& index) const {
  const auto wide = static_cast<std::size_t>(across_);
  const std::size_t at =
      (static_cast<std::size_t>(index[2]) * wide + static_cast<std::size_t>(index[1])) * wide +
      static_cast<std::size_t>(index[0]);
  return label_in_structure(labels_[at], structure);
}

bool DrawnTruth::Frame::contains(Structure structure, const Vec3& lps) const {
  return label_in_structure(label_at(in_heart(lps)), structure);
}

bool DrawnTruth::Frame::below_base(const Vec3& lps) const {
  return in_heart(lps).z() >= moment_.base;
}

DrawnTruth::Frame::Point DrawnTruth::Frame::crossing(Structure structure, const Index3& inside,
                                                     const Index3& outside) const {
  Vec3F in = place(inside);
  Vec3F out = place(outside);
  Vec3F normal = out - in;
  while ((out - in).norm() > kHalvedMm) {
    const Vec3F middle = 0.5F * (in + out);
    (label_in_structure(label_at(middle), structure) ? in : out) = middle;
  }
  const Vec3F at = 0.5F * (in + out);
  const int reach = kNormalCells;
  for (int k = -reach; k <= reach; ++k) {
    for (int j = -reach; j <= reach; ++j) {
      for (int i = -reach; i <= reach; ++i) {
        const Index3 beside{inside[0] + i, inside[1] + j, inside[2] + k};
        const Vec3F way = place(beside) - at;
        if (way.norm() > static_cast<float>(reach * spacing_mm_)) continue;
        normal += holds(structure, beside) ? Vec3F(-way) : way;
      }
    }
  }
  normal.normalize();
  Point point;
  point.lps = (truth_.axes_ * (at - truth_.heart_->middle()) + truth_.moved_mm_).cast<double>();
  point.normal = (truth_.axes_ * normal).cast<double>();
  point.area_mm2 = spacing_mm_ * spacing_mm_ / static_cast<double>(normal.lpNorm<1>());
  return point;
}

std::vector<DrawnTruth::Frame::Point> DrawnTruth::Frame::surface(Structure structure) const {
  // Nothing of the heart lies in the outermost layers, so that crossings have neighbours.
  const int last = across_ - kNormalCells;
  std::vector<std::vector<Point>> by_layer(static_cast<std::size_t>(across_));
  parallel_for(by_layer.size(), [&](std::size_t layer) {
    const auto k = static_cast<int>(layer);
    if (k < kNormalCells || k >= last) return;
    for (int j = kNormalCells; j < last; ++j) {
      for (int i = kNormalCells; i < last; ++i) {
        const Index3 here{i, j, k};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          Index3 next = here;
          ++next[axis];
          const bool in = holds(structure, here);
          if (in == holds(structure, next)) continue;
          by_layer[layer].push_back(in ? crossing(structure, here, next)
                                       : crossing(structure, next, here));
        }
      }
    }
  });
  std::vector<Point> out;
  for (const std::vector<Point>& points : by_layer) {
    out.insert(out.end(), points.begin(), points.end());
  }
  return out;
}

}  // namespace beatlas::phantom
