#include "pipeline/alarm/alarm.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>

#include "pipeline/alarm/leak_seed.h"
#include "pipeline/alarm/surface_evidence.h"
#include "pipeline/alarm/surface_points.h"
#include "pipeline/alarm/volume_jumps.h"
#include "pipeline/core/box.h"
#include "pipeline/core/parallel.h"
#include "pipeline/core/segmented_volume.h"
#include "pipeline/core/slices.h"
#include "pipeline/core/structure_mask.h"
#include "pipeline/motion/bad_frames.h"
#include "pipeline/tissue/tissue.h"
#include "runtime/base/error.h"

namespace beatlas::alarm {
namespace {

constexpr double kRoomMm = 12;        ///< around the labels, in plane
constexpr int kBorderPx = 2;          ///< what lies so near to the slices' border touches it
constexpr double kEdgeShare = 0.125;  ///< of blood above muscle: less is no edge
constexpr double kAirShare = 0.4;     ///< of muscle: darker is lung or air
/// Swing over step of an edge that stands still: one that a voxel and the smoothing make 3 mm wide
/// swings so much, over 6 mm, when it moves by 0.1 mm (standard deviation).
constexpr double kStillShare = 0.02;
constexpr double kLumpMm = 6;  ///< half a leak's width
/// Of the seeds against one leak: so many a person still reads, and none beside another's ball.
constexpr std::size_t kMostSeeds = 8;
constexpr double kSeedsApartMm = 12;

/// A patch in one phase.
struct Finding {
  double area_mm2 = 0;
  double share = 0;           ///< of the structure's surface, all patches together
  Vec3 index = Vec3::Zero();  ///< in the source's grid
  std::vector<Vec3> spread;   ///< the same of places all over it
};

Vec3 source_index(const Box& box, const Vec3& index) {
  return index + Vec3(box.first[0], box.first[1], box.first[2]);
}

/// Around all labels of the heart; no size if there are none.
Box box_of(const LabelCycle& labels) {
  const Grid& grid = labels.grid;
  Index3 room{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double step_mm = grid.spacing_mm()[static_cast<int>(a)];
    room[a] = std::max(2, static_cast<int>(std::ceil(kRoomMm / step_mm)));
  }
  return with_room(grid, box_around(grid, labels.phases), room);
}

/// A Gaussian of kLumpMm in all directions.
std::vector<float> smoothed_evenly(const Grid& grid, const std::vector<float>& image) {
  const std::vector<float> flat = tissue::smooth_in_plane(grid, image, kLumpMm);
  const double apart_mm = grid.spacing_mm()[2];
  const int reach = static_cast<int>(std::ceil(3 * kLumpMm / apart_mm));
  const std::size_t slice = grid.slice_count();
  std::vector<float> out(image.size(), 0);
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int from = std::max(0, k - reach); from <= std::min(grid.size[2] - 1, k + reach); ++from) {
      const double away = (k - from) * apart_mm / kLumpMm;
      const auto weight = static_cast<float>(std::exp(-0.5 * away * away));
      const float* source = flat.data() + static_cast<std::size_t>(from) * slice;
      float* target = out.data() + static_cast<std::size_t>(k) * slice;
      for (std::size_t v = 0; v < slice; ++v) target[v] += weight * source[v];
    }
  }
  return out;
}

std::string place_of(const Grid& grid, const Vec3& index) {
  const Vec3 lps = grid.mm(index[0], index[1], index[2]);
  char text[160];
  std::snprintf(text, sizeof text, "(%.0f, %.0f, %.0f) mm LPS, slice %d", lps[0], lps[1], lps[2],
                static_cast<int>(std::lround(index[2])));
  return text;
}

class Alarms {
 public:
  /// @param labels the part of the segmentation's in `box`
  /// @param all the segmentation's own
  Alarms(const Cine& cine, const LabelCycle& all, const ImageCycle<std::uint8_t>& labels,
         const Box& box, const LeakOptions& options)
      : cine_(cine), all_(all), labels_(labels), box_(box), options_(options) {}

  /// A patch too large: one alarm for its worst phase.
  void contact(LeakKind kind, Structure structure, const std::vector<Finding>& phases,
               double limit_mm2, const char* key) {
    std::size_t worst = 0;
    std::size_t over = 0;
    for (std::size_t p = 0; p < phases.size(); ++p) {
      if (phases[p].area_mm2 > phases[worst].area_mm2) worst = p;
      over += phases[p].area_mm2 > limit_mm2 ? 1U : 0U;
    }
    if (over == 0) return;
    const Finding& found = phases[worst];
    char area[200];
    std::snprintf(area, sizeof area, "%.0f mm2 in phase %zu", found.area_mm2, worst);
    std::string text = "the surface of " + std::string(structure_name(structure));
    switch (kind) {
      case LeakKind::ImageBorder:
        text += " runs along the border of the slices over ";
        break;
      case LeakKind::Air:
        text += " holds what is as dark as lung over ";
        break;
      case LeakKind::StillTissue:
        text += " follows an edge that does not beat over ";
        break;
      default:
        text += " has no edge in the image under ";
        break;
    }
    text += area;
    if (over > 1) text += " and too much in " + std::to_string(over - 1) + " more";
    char rest[80] = "";
    if (found.share > 0) std::snprintf(rest, sizeof rest, "%.1f %% of it, ", 100 * found.share);
    char limit[40];
    std::snprintf(limit, sizeof limit, "limit %.0f mm2, ", limit_mm2);
    text += std::string(" (") + rest + limit + key + "), worst at " +
            place_of(cine_.grid(), found.index) +
            "; look there for a leak and correct it with seeds or by painting the labels";
    add(kind, structure, static_cast<int>(worst), found.index, found.area_mm2, limit_mm2, text);
    for (const Vec3& at : found.spread) {
      const auto seed = seed_under(alarms_.back(), cine_.grid().mm_from_index * at, all_);
      if (seed) alarms_.back().seeds.push_back(*seed);
    }
  }

  void volumes(Structure structure, const std::vector<double>& curve) {
    const double limit = options_.volume_percent / 100;
    for (const VolumeJump& jump : volume_jumps(curve, limit)) {
      // Where the phase differs from those before and after the run.
      const int n = cine_.phase_count();
      const Vec3 index = place_of_jump(structure, jump.worst, (jump.first + n - 1) % n,
                                       (jump.first + jump.count) % n, jump.beyond > 0);
      add_volume(LeakKind::VolumeJump, structure, jump.worst, index, std::abs(jump.beyond),
                 jump.beyond > 0, "what the phases beside it foretell", curve);
      seed_beside_last((jump.first + n - 1) % n, (jump.first + jump.count) % n);
    }
    const double step = closing_step(curve);
    if (!(step > limit)) return;
    const int last = cine_.phase_count() - 1;
    const bool first_is_larger = curve.front() > curve.back();
    const int worst = first_is_larger ? 0 : last;
    const int other = last - worst;
    const Vec3 index = place_of_jump(structure, worst, other, other, true);
    add_volume(LeakKind::OpenCycle, structure, worst, index, step, true,
               first_is_larger ? "what the last phase foretells" : "what the first phase foretells",
               curve);
    seed_beside_last(other, other);
  }

  [[nodiscard]] std::vector<LeakAlarm> take() { return std::move(alarms_); }

 private:
  void add(LeakKind kind, Structure structure, int phase, const Vec3& index, double figure,
           double limit, std::string sentence) {
    alarms_.push_back({kind, structure, phase, cine_.grid().mm(index[0], index[1], index[2]),
                       figure, limit, std::move(sentence)});
  }

  void seed_beside_last(int before, int after) {
    LeakAlarm& alarm = alarms_.back();
    if (const auto seed = seed_beside(alarm, all_, before, after)) alarm.seeds.push_back(*seed);
  }

  void add_volume(LeakKind kind, Structure structure, int phase, const Vec3& index, double share,
                  bool above, const char* foretold, const std::vector<double>& curve) {
    char text[400];
    std::snprintf(text, sizeof text,
                  "the volume of %s in phase %d, %.1f ml, is %.0f %% of its largest %s %s (limit "
                  "%g %%, /segment/leak_volume_percent), most at ",
                  std::string(structure_name(structure)).c_str(), phase,
                  curve[static_cast<std::size_t>(phase)], 100 * share, above ? "above" : "below",
                  foretold, options_.volume_percent);
    add(kind, structure, phase, index, 100 * share, options_.volume_percent,
        text + place_of(cine_.grid(), index) +
            "; look there for a leak and correct it with seeds or by painting the labels");
    alarms_.back().sign = above ? 1 : -1;
  }

  /// The thickest spot of what `phase` has beyond both others, or both others beyond it.
  [[nodiscard]] Vec3 place_of_jump(Structure structure, int phase, int before, int after,
                                   bool above) const {
    const Grid& grid = labels_.grid;
    const auto inside = [&](int p) {
      return where(labels_.phases[static_cast<std::size_t>(p)], structure);
    };
    const std::vector<std::uint8_t> here = inside(phase);
    const std::vector<std::uint8_t> a = inside(before);
    const std::vector<std::uint8_t> b = inside(after);
    std::vector<float> differs(here.size());
    bool any = false;
    for (std::size_t v = 0; v < here.size(); ++v) {
      const bool odd =
          above ? here[v] != 0 && a[v] == 0 && b[v] == 0 : here[v] == 0 && a[v] != 0 && b[v] != 0;
      differs[v] = odd ? 1.0F : 0.0F;
      any = any || odd;
    }
    if (!any) {
      std::transform(here.begin(), here.end(), differs.begin(),
                     [](std::uint8_t in) { return in != 0 ? 1.0F : 0.0F; });
    }
    // A leak is a lump, a beat is a shell: the middle of the lump is what a wide window finds.
    const std::vector<float> dense = smoothed_evenly(grid, differs);
    const auto top =
        static_cast<std::size_t>(std::max_element(dense.begin(), dense.end()) - dense.begin());
    const Index3 at = index_of(grid, top);
    return source_index(
        box_, {static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2])});
  }

  const Cine& cine_;
  const LabelCycle& all_;
  const ImageCycle<std::uint8_t>& labels_;
  const Box& box_;
  const LeakOptions& options_;
  std::vector<LeakAlarm> alarms_;
};

/// Labels along the border of the slices in one phase.
Finding border_contact(const Grid& grid, const std::vector<std::uint8_t>& labels) {
  const Vec3 spacing = grid.spacing_mm();
  Finding found;
  Vec3 sum = Vec3::Zero();
  const auto walk = [&](int axis, bool from_end, int along, int k) {
    for (int step = 0; step <= kBorderPx; ++step) {
      const int last = grid.size[static_cast<std::size_t>(axis)] - 1;
      if (step > last) return;
      const int across = from_end ? last - step : step;
      const int i = axis == 0 ? across : along;
      const int j = axis == 0 ? along : across;
      if (labels[grid.offset(i, j, k)] == kLabelBackground) continue;
      const double area = spacing[1 - axis] * spacing[2];
      found.area_mm2 += area;
      sum += area * Vec3(i, j, k);
      return;
    }
  };
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int axis = 0; axis < 2; ++axis) {
      for (int along = 0; along < grid.size[static_cast<std::size_t>(1 - axis)]; ++along) {
        walk(axis, false, along, k);
        walk(axis, true, along, k);
      }
    }
  }
  if (found.area_mm2 > 0) found.index = sum / found.area_mm2;
  return found;
}

/// Whether a slice of the source lies wholly on the ventricles' side of the base. Thick ones at it
/// and beyond are mixtures and atria, whose outlines follow rules where nothing shows them.
bool below_base(const Segmentation& segmentation, std::size_t phase, int k) {
  const Grid& grid = segmentation.labels.grid;
  const auto plane = segmentation.valve_planes.find(Structure::LvBlood);
  if (!are_thick_slices(grid.spacing_mm()[2]) || plane == segmentation.valve_planes.end()) {
    return true;
  }
  return plane->second.base_step * (plane->second.k[phase] - k) >= 1;
}

Finding patch_of(const Grid& grid, const Box& box, const std::vector<SurfacePoint>& points,
                 const std::vector<std::uint8_t>& chosen) {
  const Patch patch = largest_patch(grid, points, chosen);
  Finding found;
  if (!(patch.area_mm2 > 0)) return found;
  double all = 0;
  double of_them = 0;
  for (std::size_t p = 0; p < points.size(); ++p) {
    all += points[p].area_mm2;
    of_them += chosen[p] != 0 ? points[p].area_mm2 : 0.0;
  }
  found.area_mm2 = patch.area_mm2;
  found.share = of_them / all;
  found.index = source_index(box, points[patch.middle].index);
  for (const std::size_t p : spread_over(patch, grid, points, kMostSeeds, kSeedsApartMm)) {
    found.spread.push_back(source_index(box, points[p].index));
  }
  return found;
}

/// Points of a structure's surface by what speaks against them, 1 where it does.
struct Suspicion {
  std::vector<std::uint8_t> bare;   ///< no edge, though not within blood
  std::vector<std::uint8_t> dark;   ///< lung or air under it
  std::vector<std::uint8_t> fixed;  ///< an edge that stands still
};

/// @param box in which the points lie
Suspicion suspicion_of(const std::vector<SurfacePoint>& points, const SurfaceEvidence& evidence,
                       const EvidenceLevels& levels, const Segmentation& segmentation,
                       std::size_t phase, const Box& box) {
  const double edge = kEdgeShare * levels.contrast;
  const double half_way = 0.5 * (levels.blood + levels.muscle);
  const bool both_known = levels.blood > 0 && levels.muscle > 0;
  const std::vector<std::uint8_t> none(points.size());
  Suspicion out{none, none, none};
  for (std::size_t q = 0; q < points.size(); ++q) {
    const bool in_blood =
        both_known && evidence.inner[q] > half_way && evidence.outer[q] > half_way;
    const bool no_edge = evidence.step[q] < edge;
    const int k = points[q].voxel[2] + box.first[2];
    out.bare[q] = no_edge && !in_blood && below_base(segmentation, phase, k) ? 1 : 0;
    out.dark[q] = levels.muscle > 0 && evidence.inner[q] < kAirShare * levels.muscle ? 1 : 0;
    out.fixed[q] = !no_edge && evidence.swing[q] < kStillShare * evidence.step[q] ? 1 : 0;
  }
  return out;
}

}  // namespace

std::vector<LeakAlarm> leak_alarms(const Cine& cine, const Segmentation& segmentation,
                                   const LeakOptions& options, StageContext& context) {
  const Box box = box_of(segmentation.labels);
  if (box.size[0] == 0) return {};
  const ImageCycle<std::uint8_t> labels = crop(segmentation.labels, box);
  Alarms alarms(cine, segmentation.labels, labels, box, options);
  // What is cut somewhere by what is in view, or by a valve's plane, may jump.
  for (const Structure structure : kVentricular) {
    const std::vector<double> curve = segmented_volume_ml(segmentation, structure);
    if (!curve.empty()) alarms.volumes(structure, curve);
  }
  context.check_cancelled();
  // A frame of noise is no evidence; that it is one is told by the segmentation.
  const std::vector<motion::BadFrame> bad = motion::bad_frames(cine.images);
  const ImageCycle<float> images = bad.empty()
                                       ? crop(cine.images, box)
                                       : crop(motion::without_bad_frames(cine.images, bad), box);
  const tissue::TemporalStats stats = tissue::temporal_stats(images);
  const EvidenceLevels levels = evidence_levels(images, labels);
  const auto n = static_cast<std::size_t>(cine.phase_count());

  constexpr std::array kWithEdges{Structure::Heart, Structure::LvBlood, Structure::RvBlood};
  std::vector<Finding> border(n);
  std::vector<Finding> air(n);
  std::vector<Finding> still(n);
  std::array<std::vector<Finding>, kWithEdges.size()> edgeless;
  for (std::vector<Finding>& list : edgeless) list.resize(n);
  parallel_for(n, [&](std::size_t p) {
    border[p] = border_contact(segmentation.labels.grid, segmentation.labels.phases[p]);
    const std::vector<float> image =
        tissue::smooth_in_plane(images.grid, images.phases[p], evidence_sigma_mm(images.grid));
    for (std::size_t s = 0; s < kWithEdges.size(); ++s) {
      const std::vector<SurfacePoint> points =
          surface_points(images.grid, where(labels.phases[p], kWithEdges[s]));
      if (points.empty()) continue;
      const SurfaceEvidence evidence =
          surface_evidence(images.grid, image, stats.swing, stats.noise, points);
      const Suspicion against = suspicion_of(points, evidence, levels, segmentation, p, box);
      edgeless[s][p] = patch_of(images.grid, box, points, against.bare);
      if (kWithEdges[s] != Structure::Heart) continue;
      air[p] = patch_of(images.grid, box, points, against.dark);
      still[p] = patch_of(images.grid, box, points, against.fixed);
    }
  });
  constexpr auto kContactKey = "/segment/leak_contact_mm2";
  alarms.contact(LeakKind::ImageBorder, Structure::Heart, border, options.contact_mm2, kContactKey);
  alarms.contact(LeakKind::Air, Structure::Heart, air, options.contact_mm2, kContactKey);
  alarms.contact(LeakKind::StillTissue, Structure::Heart, still, options.still_mm2,
                 "/segment/leak_still_mm2");
  for (std::size_t s = 0; s < kWithEdges.size(); ++s) {
    alarms.contact(LeakKind::NoEdge, kWithEdges[s], edgeless[s], options.edgeless_mm2,
                   "/segment/leak_edgeless_mm2");
  }
  return alarms.take();
}

void demand_no_leak(const std::vector<LeakAlarm>& alarms, LeakAction action) {
  if (action == LeakAction::Warn || alarms.empty()) return;
  const std::string more =
      alarms.size() == 1 ? "" : " (and " + std::to_string(alarms.size() - 1) + " more alarms)";
  throw Error(ErrorCode::Quality, alarms.front().sentence + more +
                                      "; the recipe makes a leak an error (/segment/leak)");
}

}  // namespace beatlas::alarm
