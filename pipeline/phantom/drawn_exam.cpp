#include "pipeline/phantom/drawn_exam.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <span>
#include <stdexcept>
#include <vector>

#include "pipeline/core/parallel.h"
#include "pipeline/phantom/drawn_scanner.h"
#include "pipeline/phantom/drawn_signal.h"
#include "pipeline/phantom/drawn_slices.h"
#include "runtime/base/sha256.h"

namespace beatlas::phantom {
namespace {

constexpr float kLatticeMm = 2;
constexpr double kVolumeErrorMl = 0.5;
constexpr std::uint32_t kAttemptStep = kMostDrawSeed + 1;

/// Cubes about the heart in its frame, of which none beside them holds any of it at any time of the
/// beat, as far as their middles and those of their neighbours can tell.
struct HeartCells {
  float edge = 0;
  std::vector<Vec3F> corners;
};

HeartCells cells_of(const DrawnHeart& heart) {
  HeartCells out{.edge = 4 * kLatticeMm, .corners = {}};
  const auto n = static_cast<int>(heart.reach() / out.edge) + 2;
  const int across = 2 * n + 1;
  const auto at = [&](int i, int j, int k) {
    return static_cast<std::size_t>(((k + n) * across + j + n) * across + i + n);
  };
  const auto corner = [&](int i, int j, int k) -> Vec3F {
    return heart.middle() +
           out.edge * Vec3F(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
  };
  const std::array<DrawnHeart::Moment, 3> moments{heart.moment(0), heart.moment(0.5F),
                                                  heart.moment(1)};
  std::vector<std::uint8_t> wanted(static_cast<std::size_t>(across * across * across));
  for (int k = 1 - n; k < n; ++k) {
    for (int j = 1 - n; j < n; ++j) {
      for (int i = 1 - n; i < n; ++i) {
        const Vec3F middle = corner(i, j, k) + Vec3F::Constant(0.5F * out.edge);
        const bool holds = std::any_of(moments.begin(), moments.end(), [&](const auto& moment) {
          return heart.at(middle, moment) != Tissue::Outside;
        });
        if (!holds) continue;
        for (int d = 0; d < 27; ++d) {
          wanted[at(i + d % 3 - 1, j + d / 3 % 3 - 1, k + d / 9 - 1)] = 1;
        }
      }
    }
  }
  for (int k = -n; k <= n; ++k) {
    for (int j = -n; j <= n; ++j) {
      for (int i = -n; i <= n; ++i) {
        if (wanted[at(i, j, k)] != 0) out.corners.push_back(corner(i, j, k));
      }
    }
  }
  return out;
}

/// Calls body(place, label) at each point of a lattice of `per_edge` points along a cell's edge
/// that is of the heart.
template <class Body>
void each_heart_point(const DrawnHeart& heart, const HeartCells& cells, float contraction,
                      int per_edge, const Body& body) {
  const DrawnHeart::Moment moment = heart.moment(contraction);
  const float step = cells.edge / static_cast<float>(per_edge);
  for (const Vec3F& corner : cells.corners) {
    for (int k = 0; k < per_edge; ++k) {
      for (int j = 0; j < per_edge; ++j) {
        for (int i = 0; i < per_edge; ++i) {
          // Each column has heights of its own, so that no valve plane falls between two layers.
          const auto x = static_cast<float>(i);
          const auto y = static_cast<float>(j);
          const float height = 0.43F + 0.618F * x + 0.755F * y;
          const Vec3F place =
              corner + step * Vec3F(x + 0.31F, y + 0.17F,
                                    static_cast<float>(k) + height - std::floor(height));
          const std::uint8_t label = label_of(heart.at(place, moment));
          if (label != kLabelBackground) body(place, label);
        }
      }
    }
  }
}

std::array<double, 8> volumes_ml(const DrawnHeart& heart, const HeartCells& cells,
                                 float contraction, int per_edge) {
  std::array<std::size_t, 8> points{};
  each_heart_point(heart, cells, contraction, per_edge,
                   [&](const Vec3F&, std::uint8_t label) { ++points[label]; });
  std::array<double, 8> out{};
  const double voxel_ml = std::pow(static_cast<double>(cells.edge) / per_edge, 3) / 1000;
  for (std::size_t label = 1; label < out.size(); ++label) {
    out[label] = static_cast<double>(points[label]) * voxel_ml;
  }
  return out;
}

constexpr int kPerEdge = 4;  ///< a lattice of kLatticeMm

/// A draw, before it is imaged.
struct ExamDraw {
  Family family;
  DrawnHeart heart;
  bool has_heart;
  DrawnBody body;
  Eigen::Matrix3f axes;
  DrawnStack stack;

  ExamDraw(const Family& drawn, int most_voxels)
      : family(drawn),
        heart(family),
        has_heart(!family.happens("no_heart")),
        body(family, heart.reach()),
        axes(heart_axes(family)),
        stack(drawn_stack(family, heart, axes, most_voxels)) {}

  [[nodiscard]] DrawnScene scene() const {
    return {has_heart ? &heart : nullptr, &body, axes, heart.middle(), heart.reach()};
  }
  [[nodiscard]] VoxelShape shape() const {
    return family.purpose() == Purpose::Judging && family.happens("exam_rendering")
               ? VoxelShape::Profile
               : VoxelShape::Box;
  }
};

/// What a draw came to, by the lattice.
struct Measured {
  float lv_edv = 0, lv_ef = 0;      // ml, %
  float rv_over_lv = 0, rv_ef = 0;  // %, both
  float wall = 0;                   // mm
  float in_view = 0;                // share of the LV's blood
  int lv_slices = 0;                // in which the LV's cavity is at least a thumb wide
  bool cropped = false;             // the LV leaves the view within a slice
  float contrast = 0;               // of blood over muscle, in the brightest tissue
  float cnr = 0;                    // in noise
};

Measured measure(const ExamDraw& draw) {
  Measured out;
  const float voxel_ml = kLatticeMm * kLatticeMm * kLatticeMm / 1000;
  const Affine index_from_lps = draw.stack.grid().mm_from_index.inverse();
  const float length = draw.heart.length();
  constexpr float kMarginMm = 4;
  const double margin = kMarginMm / draw.stack.pixel_mm;
  const double last = draw.stack.columns - 1 - margin;
  std::array<double, 8> full{};
  std::array<double, 8> band{};
  double seen = 0;
  std::vector<double> slice_ml(static_cast<std::size_t>(draw.stack.slices));
  const HeartCells cells = cells_of(draw.heart);
  each_heart_point(draw.heart, cells, 0, kPerEdge, [&](const Vec3F& place, std::uint8_t label) {
    full[label] += voxel_ml;
    if (std::abs(place.z() - 0.5F * length) < 0.06F * length) band[label] += voxel_ml;
    if (label != kLabelLvBlood && label != kLabelLvMyocardium) return;
    const Vec3F lps = draw.axes * (place - draw.heart.middle());
    const Vec3 index = index_from_lps * lps.cast<double>();
    const double k = std::round(index.z());
    if (k < 0 || k > draw.stack.slices - 1) return;
    const bool within =
        std::min(index.x(), index.y()) > margin && std::max(index.x(), index.y()) < last;
    if (!within) out.cropped = true;
    if (label != kLabelLvBlood || !within) return;
    seen += voxel_ml;
    slice_ml[static_cast<std::size_t>(k)] += voxel_ml;
  });
  const std::array<double, 8> empty = volumes_ml(draw.heart, cells, 1, kPerEdge);
  const auto share = [](double part, double whole) {
    return static_cast<float>(whole > 0 ? part / whole : 0);
  };
  out.lv_edv = static_cast<float>(full[kLabelLvBlood]);
  out.lv_ef = 100 * (1 - share(empty[kLabelLvBlood], full[kLabelLvBlood]));
  out.rv_over_lv = share(full[kLabelRvBlood], full[kLabelLvBlood]);
  out.rv_ef = 100 * (1 - share(empty[kLabelRvBlood], full[kLabelRvBlood]));
  out.in_view = share(seen, full[kLabelLvBlood]);
  const double height = 0.12 * length;
  const auto radius = [&](double ml) { return std::sqrt(ml * 1000 / height / std::numbers::pi); };
  out.wall = static_cast<float>(radius(band[kLabelLvBlood] + band[kLabelLvMyocardium]) -
                                radius(band[kLabelLvBlood]));
  constexpr double kThumbMm2 = 150;
  for (const double ml : slice_ml) {
    if (ml * 1000 / draw.stack.distance_mm > kThumbMm2) ++out.lv_slices;
  }
  const TissueSignals signals = draw_signals(draw.family);
  const float contrast = signals[static_cast<std::size_t>(Tissue::LvBlood)] -
                         signals[static_cast<std::size_t>(Tissue::LvMuscle)];
  out.contrast = contrast / *std::max_element(signals.begin(), signals.end());
  out.cnr = contrast * draw.family.number("snr");
  return out;
}

/// Whether a person could have this heart and a scanner such a stack of it.
bool is_sound(const Measured& m) {
  constexpr int kLeastSlices = 3;  // Fewer show no ventricle but a hole.
  return Family::in_range("exam_lv_edv", m.lv_edv) && Family::in_range("exam_lv_ef", m.lv_ef) &&
         Family::in_range("exam_rv_over_lv", m.rv_over_lv) &&
         Family::in_range("exam_rv_ef", m.rv_ef) && Family::in_range("exam_wall", m.wall) &&
         Family::in_range("exam_in_view", m.in_view) && Family::in_range("exam_cnr", m.cnr) &&
         Family::in_range("exam_contrast", m.contrast) && m.lv_slices >= kLeastSlices && !m.cropped;
}

std::vector<std::uint8_t> labels_of(const ExamDraw& draw, float contraction, bool shifted) {
  const DrawnScene scene = draw.scene();
  const DrawnHeart::Moment moment = draw.heart.moment(contraction);
  const int n = draw.stack.columns;
  const std::size_t pixels = static_cast<std::size_t>(n) * static_cast<std::size_t>(n);
  std::vector<std::uint8_t> out(pixels * static_cast<std::size_t>(draw.stack.slices));
  if (!draw.has_heart) return out;
  parallel_for(static_cast<std::size_t>(draw.stack.slices), [&](std::size_t k) {
    const Eigen::Vector2f shift =
        shifted ? draw.stack.shifts[k] : Eigen::Vector2f(Eigen::Vector2f::Zero());
    const std::vector<std::uint8_t> near =
        near_heart(scene, draw.stack, static_cast<int>(k), shift, 0);
    std::size_t at = k * pixels;
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i, ++at) {
        if (near[at - k * pixels] == 0) continue;
        out[at] =
            label_of(scene.heart_at(draw.stack.seen_at(static_cast<float>(i), static_cast<float>(j),
                                                       static_cast<float>(k), shift),
                                    moment));
      }
    }
  });
  return out;
}

nlohmann::json stack_json(const DrawnStack& stack) {
  nlohmann::json shifts = nlohmann::json::array();
  for (const Eigen::Vector2f& shift : stack.shifts) shifts.push_back({shift.x(), shift.y()});
  return {{"plane", stack.plane},
          {"columns", stack.columns},
          {"slices", stack.slices},
          {"pixel_mm", stack.pixel_mm},
          {"distance_mm", stack.distance_mm},
          {"thickness_mm", stack.thickness_mm},
          {"shifts_mm", shifts}};
}

/// Numbers of the family that a reader of failures asks for first.
nlohmann::json drawn_json(const Family& family) {
  nlohmann::json out;
  for (const char* name : {"lv_edv", "lv_ef", "wall", "lv_long_share", "rv_over_lv", "rv_ef",
                           "rv_long_share", "trabeculae", "snr", "shading", "shift", "gamma"}) {
    out[name] = family.number(name);
  }
  for (const char* name : {"infarct", "effusion", "random_contrast", "arms", "masked", "ghosts"}) {
    out[name] = family.happens(name);
  }
  return out;
}

nlohmann::json measured_json(const Measured& m) {
  return {{"lv_edv", m.lv_edv},
          {"lv_ef", m.lv_ef},
          {"rv_over_lv", m.rv_over_lv},
          {"rv_ef", m.rv_ef},
          {"wall", m.wall},
          {"in_view", m.in_view},
          {"lv_slices", m.lv_slices},
          {"blood_over_muscle", m.contrast},
          {"blood_over_muscle_in_noise", m.cnr}};
}

/// [phase][label][ml]; zeros where there is no heart.
std::vector<std::array<double, 8>> volumes_of(const ExamDraw& draw) {
  std::vector<std::array<double, 8>> out(draw.stack.times.size());
  if (!draw.has_heart) return out;
  const HeartCells cells = cells_of(draw.heart);
  parallel_for(out.size(), [&](std::size_t p) {
    out[p] = volumes_ml(draw.heart, cells, contraction_at(draw.stack.times[p]), kPerEdge);
  });
  return out;
}

nlohmann::json structures_json(const std::vector<std::array<double, 8>>& volumes) {
  nlohmann::json out = nlohmann::json::array();
  for (const Structure structure : kAllStructures) {
    nlohmann::json curve = nlohmann::json::array();
    for (const auto& by_label : volumes) {
      double ml = 0;
      for (std::uint8_t label = 1; label < by_label.size(); ++label) {
        if (label_in_structure(label, structure)) ml += by_label[label];
      }
      curve.push_back(ml);
    }
    out.push_back({{"name", std::string(structure_name(structure))}, {"volume_ml", curve}});
  }
  return out;
}

nlohmann::json truth_of(const ExamDraw& draw, std::uint32_t seed, std::uint32_t attempt,
                        const Measured& measured) {
  const DrawnStack& stack = draw.stack;
  nlohmann::json times = nlohmann::json::array();
  nlohmann::json contraction = nlohmann::json::array();
  for (const float time : stack.times) {
    times.push_back(time * stack.rr_interval_s);
    contraction.push_back(contraction_at(time));
  }
  nlohmann::json out{
      {"format", kDrawnTruthFormat},
      {"version", kDrawnTruthVersion},
      {"seed", seed},
      {"attempt", attempt},
      {"purpose", draw.family.purpose() == Purpose::Judging ? "judging" : "training"},
      {"has_heart", draw.has_heart},
      {"rendering", draw.shape() == VoxelShape::Profile ? "profile" : "box"},
      {"rr_interval_s", stack.rr_interval_s},
      {"times_s", times},
      {"contraction", contraction},
      {"stack", stack_json(stack)},
      {"drawn", drawn_json(draw.family)},
      {"volume_error_ml", kVolumeErrorMl},
      {"structures", structures_json(volumes_of(draw))}};
  if (draw.has_heart) {
    out["measured"] = measured_json(measured);
    out["ejection_fraction"] = {{"lv_blood", measured.lv_ef / 100},
                                {"rv_blood", measured.rv_ef / 100}};
  }
  const std::string text = out.dump();
  out["identity"] = sha256_hex(std::as_bytes(std::span(text.data(), text.size())));
  return out;
}

}  // namespace

Family exam_family(std::uint32_t seed, std::uint32_t attempt) {
  return {seed + attempt * kAttemptStep,
          seed < kFirstJudgingSeed ? Purpose::Training : Purpose::Judging};
}

std::array<double, 8> drawn_volumes_ml(const DrawnHeart& heart, float contraction, int per_edge) {
  return volumes_ml(heart, cells_of(heart), contraction, per_edge);
}

DrawnExam drawn_exam(std::uint32_t seed, const DrawnExamOptions& options, StageContext& context) {
  for (std::uint32_t attempt = 0; attempt < kMostDrawAttempts; ++attempt) {
    context.check_cancelled();
    const ExamDraw draw(exam_family(seed, attempt), options.most_voxels);
    const Measured measured = draw.has_heart ? measure(draw) : Measured();
    if (draw.has_heart && !is_sound(measured)) continue;
    DrawnExam out;
    out.truth = truth_of(draw, seed, attempt, measured);
    out.identity = out.truth["identity"];
    out.slice_thickness_mm = draw.stack.thickness_mm;
    out.labels.grid = draw.stack.grid();
    out.source_labels.grid = out.labels.grid;
    for (const float time : draw.stack.times) {
      const float contraction = contraction_at(time);
      out.labels.phases.push_back(labels_of(draw, contraction, false));
      out.source_labels.phases.push_back(labels_of(draw, contraction, true));
    }
    out.cine = imaged_stack(draw.family, draw.scene(), draw.stack, draw.shape(), context);
    for (const DrawnStack& view :
         drawn_views(draw.family, draw.heart, draw.axes, draw.stack, options.views)) {
      out.view_thickness_mm = view.thickness_mm;
      out.views.push_back(imaged_stack(draw.family, draw.scene(), view, draw.shape(), context));
    }
    return out;
  }
  throw std::logic_error("no draw of seed " + std::to_string(seed) +
                         " is within family.json's limits");
}

}  // namespace beatlas::phantom
