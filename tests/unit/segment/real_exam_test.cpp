/// Segmentation of real exams, which are no part of the project: skipped where they are absent.
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "pipeline/core/segmented_volume.h"
#include "pipeline/ingest/ingest.h"
#include "pipeline/segment/segment.h"
#include "tests/real_exams.h"
#include "tests/unit/segment/imaged_phantom.h"

namespace beatlas::segment {
namespace {

using test::real_exam;

using Polygon = std::vector<Eigen::Vector2d>;  ///< column, row

Polygon contour(int number) {
  char name[64];
  std::snprintf(name, sizeof name, "IM-0001-%04d-icontour-manual.txt", number);
  std::ifstream file(real_exam("two-phase-ge") / "contours" / name);
  Polygon out;
  for (double x = 0, y = 0; file >> x >> y;) out.emplace_back(x, y);
  return out;
}

bool inside(const Polygon& polygon, double x, double y) {
  bool in = false;
  for (std::size_t a = 0, b = polygon.size() - 1; a < polygon.size(); b = a++) {
    const Eigen::Vector2d& p = polygon[a];
    const Eigen::Vector2d& q = polygon[b];
    if ((p.y() > y) != (q.y() > y) && x < (q.x() - p.x()) * (y - p.y()) / (q.y() - p.y()) + p.x()) {
      in = !in;
    }
  }
  return in;
}

/// Of the LV's cavity in all slices of a phase, against the experts' contours.
double dice(const Segmentation& result, const std::vector<int>& numbers, std::size_t phase) {
  const Grid& grid = result.labels.grid;
  std::size_t both = 0;
  std::size_t sum = 0;
  for (int k = 0; k < grid.size[2]; ++k) {
    const Polygon expert = contour(numbers[static_cast<std::size_t>(k)]);
    EXPECT_GT(expert.size(), 10U);
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        const bool theirs = inside(expert, i, j);
        const bool ours = result.labels.phases[phase][grid.offset(i, j, k)] == kLabelLvBlood;
        both += theirs && ours ? 1 : 0;
        sum += (theirs ? 1 : 0) + (ours ? 1 : 0);
      }
    }
  }
  return 2.0 * static_cast<double>(both) / static_cast<double>(sum);
}

/// Half of what the last slice towards the base holds at its fullest.
double half_of_basal_ml(const Segmentation& result, Structure structure) {
  const Grid& grid = result.labels.grid;
  std::size_t most = 0;
  for (const auto& phase : result.labels.phases) {
    const auto last =
        phase.begin() + static_cast<std::ptrdiff_t>(grid.offset(0, 0, grid.size[2] - 1));
    most = std::max(most,
                    static_cast<std::size_t>(std::count(last, phase.end(), label_of(structure))));
  }
  return 0.5 * grid.voxel_ml() * static_cast<double>(most);
}

// Numbers of the experts' contours in the slices of the stack, from the apex on.
const std::vector<int> kEndDiastole{100, 80, 60, 40};
const std::vector<int> kEndSystole{88, 68, 48, 28};

TEST(RealExam, OfTwoPhasesHasTheExpertsCavityWithThreeStrokesAtEndSystole) {
  BEATLAS_NEEDS_REAL_EXAM("two-phase-ge");
  StageContext context;
  const Exam exam = ingest::read_exam({real_exam("two-phase-ge")}, {}, context);
  const Segmentation automatic = made::segmented(exam, made::Views::All);
  EXPECT_GE(dice(automatic, kEndDiastole, 0), 0.90);
  EXPECT_GE(dice(automatic, kEndSystole, 1), 0.855);

  // At end-systole trabeculae and papillary muscles, which count as cavity, fill half of it: one
  // stroke a slice along their outer rim, as a technician draws it.
  const Grid& grid = exam.stack.grid();
  const auto stroke = [&](int k, const std::vector<Vec3>& at) {
    Seed seed{kLabelLvBlood, grid.mm(at[0][0], at[0][1], k), 2.0, 1, {}};
    for (std::size_t n = 1; n < at.size(); ++n) {
      seed.stroke_lps_mm.push_back(grid.mm(at[n][0], at[n][1], k));
    }
    return seed;
  };
  const std::vector<Seed> strokes{
      stroke(0, {{139, 115, 0}, {143, 124, 0}, {139, 133, 0}}),
      stroke(1, {{141, 118, 0}, {147, 127, 0}, {141, 137, 0}}),
      stroke(2, {{141, 118, 0}, {147, 127, 0}, {141, 137, 0}}),
  };
  const Segmentation corrected = made::segmented(exam, made::Views::All, strokes);
  EXPECT_GE(dice(corrected, kEndDiastole, 0), 0.90);
  // The prior sees the rim by itself now; whoever marks it all the same draws the cavity a little
  // larger than the experts did.
  EXPECT_GE(dice(corrected, kEndSystole, 1), 0.83);
}

TEST(RealExam, OfDistantSlicesHasNearlyTheVolumesOfAnIndependentFit) {
  BEATLAS_NEEDS_REAL_EXAM("cine-exam");
  StageContext context;
  const Exam exam = ingest::read_exam({real_exam("cine-exam")}, {}, context);
  const Segmentation result = made::segmented(exam, made::Views::All);
  // By itself the network takes the LV's apex, in the last slice, for RV.
  ASSERT_EQ(result.warnings.size(), 1U);
  EXPECT_NE(result.warnings[0].find("slice 0 is labelled after the long-axis views"),
            std::string::npos);
  // Of a fit of biventricular surfaces, whose own doubt is a tenth. Slices lie 17.7 mm apart, and
  // what the most basal one holds of the RV at end-diastole is not seen.
  const auto expect_volumes = [&](Structure structure, double end_diastolic_ml, double off,
                                  double end_systolic_ml, double off_end) {
    const std::vector<double> curve = segmented_volume_ml(result, structure);
    const auto [least, most] = std::minmax_element(curve.begin(), curve.end());
    // A volume curve is smooth: no phase stands off its neighbours' mean by a seventh of the swing,
    // or by half of what the most basal slice holds, which may be ventricle in one phase and atrium
    // in the next.
    const double least_off = half_of_basal_ml(result, structure);
    for (std::size_t p = 0; p < curve.size(); ++p) {
      const double mean =
          0.5 * (curve[(p + 1) % curve.size()] + curve[(p + curve.size() - 1) % curve.size()]);
      EXPECT_LT(std::abs(curve[p] - mean), std::max((*most - *least) / 7, least_off))
          << structure_name(structure) << " " << p;
    }
    EXPECT_NEAR(*most / end_diastolic_ml, 1, off) << structure_name(structure);
    EXPECT_NEAR(*least / end_systolic_ml, 1, off_end) << structure_name(structure);
  };
  expect_volumes(Structure::LvBlood, 179, 0.1, 72, 0.1);
  expect_volumes(Structure::RvBlood, 211, 0.20, 99, 0.15);
  // The mitral plane descends by what a healthy heart's does [mm].
  const ValvePlane& base = result.valve_planes.at(Structure::LvBlood);
  const auto [low, high] = std::minmax_element(base.k.begin(), base.k.end());
  const double excursion_mm = (*high - *low) * exam.stack.grid().spacing_mm()[2];
  EXPECT_GT(excursion_mm, 8);
  EXPECT_LT(excursion_mm, 20);
}

}  // namespace
}  // namespace beatlas::segment
