/// Every stage's values come back bit by bit: the condition for the same package stage by stage.
#include "pipeline/study/stage_files.h"

#include <algorithm>
#include <cmath>
#include <fstream>

#include <gtest/gtest.h>

#include "pipeline/study/files.h"
#include "pipeline/study/images.h"
#include "pipeline/study/stage.h"
#include "runtime/base/error.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas::study {
namespace {
namespace fs = std::filesystem;

constexpr int kPhases = 3;

/// An oblique grid whose numbers are no floats.
Grid oblique_grid(const Index3& size) {
  Grid grid{size, Affine::Identity()};
  grid.mm_from_index.linear() =
      (Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()).toRotationMatrix() *
       Vec3(1.1, 1.3, 7.7).asDiagonal());
  grid.mm_from_index.translation() = Vec3(-100.0 / 3, 1e-3 / 7, 250.1);
  return grid;
}

std::vector<float> wave(std::size_t count, double scale, double shift) {
  std::vector<float> out(count);
  for (std::size_t at = 0; at < count; ++at) {
    out[at] = static_cast<float>(scale * std::sin(0.37 * static_cast<double>(at) + shift));
  }
  return out;
}

ImageCycle<float> images(const Grid& grid, double scale, bool whole) {
  ImageCycle<float> out{grid, {}};
  for (int p = 0; p < kPhases; ++p) {
    out.phases.push_back(wave(grid.count(), scale, p));
    if (whole) {
      for (float& value : out.phases.back()) value = std::round(value) + 0.0F;
    }
  }
  return out;
}

void expect_same(const ImageCycle<float>& a, const ImageCycle<float>& b) {
  EXPECT_TRUE(a.grid == b.grid);
  EXPECT_EQ(a.phases, b.phases);
}

Cine cine(const Index3& size, bool whole) {
  return {images(oblique_grid(size), 900.5, whole), 0.8 / 3, {0.0, 0.1 / 3, 0.2}};
}

TEST(StageFiles, AnExamComesBackBitByBit) {
  for (bool whole : {true, false}) {
    const TemporaryFolder folder;
    const Exam exam{cine({7, 5, 4}, whole),
                    {cine({4, 6, 1}, whole), cine({3, 3, 1}, whole)},
                    {"Took \"this\", left that."},
                    {Vec2(0.5, -1.25), Vec2(0, 2), Vec2(-1, 1.0 / 3), Vec2(0, 0)},
                    {0, -2, 1, 0},
                    "dicom",
                    {},
                    {}};
    const FileList files = write_exam(folder.path(), exam);
    for (const std::string& file : files) EXPECT_TRUE(fs::exists(folder.path() / file)) << file;
    const Exam again = read_exam(folder.path());
    expect_same(exam.stack.images, again.stack.images);
    EXPECT_EQ(exam.stack.rr_interval_s, again.stack.rr_interval_s);
    EXPECT_EQ(exam.stack.frame_times_s, again.stack.frame_times_s);
    ASSERT_EQ(again.views.size(), 2U);
    expect_same(exam.views[1].images, again.views[1].images);
    EXPECT_EQ(exam.decisions, again.decisions);
    EXPECT_EQ(exam.slice_shifts_mm, again.slice_shifts_mm);
    EXPECT_EQ(exam.slice_lags, again.slice_lags);
    EXPECT_EQ(exam.source_format, again.source_format);
  }
}

Segmentation make_segmentation() {
  Segmentation out;
  out.labels.grid = oblique_grid({9, 8, 4});
  out.labels.phases.assign(kPhases, std::vector<std::uint8_t>(out.labels.grid.count(), 0));
  out.labels.phases[1][17] = kLabelLvBlood;
  out.coverage.first = {2, 1, 1};
  out.coverage.grid = out.labels.grid.part({2, 1, 1}, {5, 6, 2});
  for (Structure structure : {Structure::Heart, Structure::RvBlood}) {
    for (int p = 0; p < kPhases; ++p) {
      std::vector<float> coverage = wave(out.coverage.grid.count(), 0.5, p);
      for (float& value : coverage) value += 0.5F;
      out.coverage.phases[structure].push_back(coverage);
    }
  }
  out.end_diastole = 2;
  out.end_systole = 1;
  out.valve_planes[Structure::LvBlood] = {-1, {1.0 / 3, 2.5, 0.1}};
  out.axis = LongAxis{Vec3(10, -20.0 / 3, 7),
                      Vec3(0.1, -0.7, 1.0 / 3).normalized(),
                      {-60.5, -61.0 / 3, -60},
                      {30, 20, 10.0 / 7},
                      {31, 22, 9},
                      true,
                      Vec3(-40, 2.0 / 3, 11)};
  for (int p = 0; p < kPhases; ++p) {
    out.uncertainty[Structure::RvBlood].push_back(
        {{static_cast<std::uint32_t>(p), 0.1F}, {static_cast<std::uint32_t>(p + 7), 1.0F / 3}});
  }
  out.belief[Structure::LvBlood].assign(
      kPhases, std::vector<SliceBelief>(static_cast<std::size_t>(out.labels.grid.size[2]),
                                        {812.5, 0.1, 700.3}));
  out.warnings = {"thin"};
  out.alarms = {{LeakKind::StillTissue,
                 Structure::RvBlood,
                 1,
                 Vec3(0.1, -2.0 / 3, 7),
                 812.5,
                 200,
                 "it follows an edge that does not beat",
                 {{kLabelLvMyocardium, Vec3(1.0 / 3, 2, 3), 4.5, -1},
                  {kLabelBackground, Vec3(4, 5, 6), 2, 0}},
                 -1}};
  return out;
}

TEST(StageFiles, ASegmentationComesBackBitByBit) {
  const TemporaryFolder folder;
  const Segmentation segmentation = make_segmentation();
  (void)write_segmentation(folder.path(), segmentation, 0.05);
  const StoredSegmentation stored = read_segmentation(folder.path());
  const Segmentation& again = stored.made;
  EXPECT_EQ(segmentation.labels.phases, stored.labels.phases);
  EXPECT_TRUE(segmentation.labels.grid == again.labels.grid);
  EXPECT_EQ(segmentation.labels.phases, again.labels.phases);
  EXPECT_TRUE(segmentation.coverage.grid == again.coverage.grid);
  EXPECT_EQ(segmentation.coverage.first, again.coverage.first);
  EXPECT_EQ(segmentation.coverage.phases, again.coverage.phases);
  EXPECT_EQ(segmentation.end_diastole, again.end_diastole);
  EXPECT_EQ(segmentation.end_systole, again.end_systole);
  EXPECT_EQ(segmentation.warnings, again.warnings);
  const auto& belief = again.belief.at(Structure::LvBlood);
  ASSERT_EQ(belief.size(), static_cast<std::size_t>(kPhases));
  ASSERT_EQ(belief.back().size(), static_cast<std::size_t>(segmentation.labels.grid.size[2]));
  EXPECT_EQ(belief.back().back().labelled_mm2, 812.5);
  EXPECT_EQ(belief.back().back().expected_mm2, 0.1);
  EXPECT_EQ(belief.back().back().agreed_mm2, 700.3);
  ASSERT_EQ(again.alarms.size(), 1U);
  const LeakAlarm& alarm = segmentation.alarms.front();
  EXPECT_EQ(again.alarms[0].kind, alarm.kind);
  EXPECT_EQ(again.alarms[0].structure, alarm.structure);
  EXPECT_EQ(again.alarms[0].phase, alarm.phase);
  EXPECT_EQ(again.alarms[0].lps_mm, alarm.lps_mm);
  EXPECT_EQ(again.alarms[0].figure, alarm.figure);
  EXPECT_EQ(again.alarms[0].limit, alarm.limit);
  EXPECT_EQ(again.alarms[0].sentence, alarm.sentence);
  EXPECT_EQ(again.alarms[0].sign, -1);
  ASSERT_EQ(again.alarms[0].seeds.size(), 2U);
  for (std::size_t s = 0; s < 2; ++s) {
    EXPECT_EQ(again.alarms[0].seeds[s].label, alarm.seeds[s].label);
    EXPECT_EQ(again.alarms[0].seeds[s].lps_mm, alarm.seeds[s].lps_mm);
    EXPECT_EQ(again.alarms[0].seeds[s].radius_mm, alarm.seeds[s].radius_mm);
    EXPECT_EQ(again.alarms[0].seeds[s].phase, alarm.seeds[s].phase);
  }
  ASSERT_EQ(again.valve_planes.size(), 1U);
  EXPECT_EQ(again.valve_planes.at(Structure::LvBlood).base_step, -1);
  EXPECT_EQ(again.valve_planes.at(Structure::LvBlood).k,
            segmentation.valve_planes.at(Structure::LvBlood).k);
}

TEST(StageFiles, ValvePlanesAreReadUnderTheirFormerName) {
  const TemporaryFolder folder;
  const Segmentation segmentation = make_segmentation();
  (void)write_segmentation(folder.path(), segmentation, 0.05);
  const std::filesystem::path file = folder.path() / "segment" / "segment.json";
  nlohmann::json content = read_json(file);
  content["base_cuts"] = content.at("valve_planes");
  content.erase("valve_planes");
  write_json(file, content);
  EXPECT_EQ(read_segmentation(folder.path()).made.valve_planes.at(Structure::LvBlood).k,
            segmentation.valve_planes.at(Structure::LvBlood).k);
}

TEST(StageFiles, TheLongAxisComesBackBitByBit) {
  const TemporaryFolder folder;
  const Segmentation made = make_segmentation();
  (void)write_segmentation(folder.path(), made, 0.05);
  const std::optional<LongAxis> again = read_segmentation(folder.path()).made.axis;
  ASSERT_TRUE(again);
  EXPECT_EQ(again->origin_mm, made.axis->origin_mm);
  EXPECT_EQ(again->towards_base, made.axis->towards_base);
  EXPECT_EQ(again->apex_mm, made.axis->apex_mm);
  EXPECT_EQ(again->lv_base_mm, made.axis->lv_base_mm);
  EXPECT_EQ(again->rv_base_mm, made.axis->rv_base_mm);
  EXPECT_EQ(again->atria, made.axis->atria);
  EXPECT_EQ(again->rv_centre_mm, made.axis->rv_centre_mm);
  EXPECT_EQ(read_long_axis(folder.path())->apex_mm, made.axis->apex_mm);
}

TEST(StageFiles, AHeartWithoutAnAxisHasNoneWhateverLiesInTheFolder) {
  const TemporaryFolder folder;
  Segmentation made = make_segmentation();
  (void)write_segmentation(folder.path(), made, 0.05);
  made.axis.reset();
  const FileList files = write_segmentation(folder.path(), made, 0.05);
  EXPECT_EQ(std::count(files.begin(), files.end(), "segment/long_axis.json"), 0);
  EXPECT_FALSE(read_segmentation(folder.path()).made.axis);
  EXPECT_FALSE(read_long_axis(folder.path()));
}

TEST(StageFiles, ALongAxisThatIsNoneIsRefusedByItsPlace) {
  const TemporaryFolder folder;
  (void)write_segmentation(folder.path(), make_segmentation(), 0.05);
  const fs::path file = folder.path() / "segment" / "long_axis.json";
  const nlohmann::json good = read_json(file);
  const auto refusal = [&](const nlohmann::json& changed) -> std::string {
    write_json(file, changed);
    try {
      (void)read_segmentation(folder.path());
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
      return error.what();
    }
    return "(accepted)";
  };
  const auto with = [&](const char* pointer, const nlohmann::json& value) {
    nlohmann::json changed = good;
    changed[nlohmann::json::json_pointer(pointer)] = value;
    return changed;
  };
  EXPECT_EQ(refusal(good), "(accepted)");
  EXPECT_NE(refusal(with("/version", 2)).find("/version is 2"), std::string::npos);
  EXPECT_NE(refusal(with("/towards_base_lps", {0, 0, 0})).find("long_axis.json"),
            std::string::npos);
  EXPECT_NE(refusal(with("/phases/1/lv_base_mm", -100)).find("/phases/1"), std::string::npos);
  EXPECT_NE(refusal(with("/phases/1/lv_base_mm", "x")).find("/phases/1/lv_base_mm"),
            std::string::npos);
  EXPECT_NE(refusal(with("/phases/1/middle_mm", 1)).find("/phases/1/middle_mm"), std::string::npos);
  EXPECT_NE(refusal(with("/rv_centre_lps_mm", {1, 2})).find("/rv_centre_lps_mm"),
            std::string::npos);
  EXPECT_NE(refusal(with("/rv_centre_lps_mm", good["origin_lps_mm"])).find("beside the axis"),
            std::string::npos);
  nlohmann::json changed = good;
  changed["phases"][2].erase("rv_base_mm");
  EXPECT_NE(refusal(changed).find("in each or in none"), std::string::npos);
  changed = good;
  changed["phases"].erase(0);
  EXPECT_NE(refusal(changed).find("must have 3 entries"), std::string::npos);
}

TEST(StageFiles, UncertaintyComesBackBitByBit) {
  const TemporaryFolder folder;
  const Segmentation made = make_segmentation();
  (void)write_segmentation(folder.path(), made, 0.05);
  const BoundaryUncertainty again = read_uncertainty(folder.path());
  ASSERT_EQ(again.size(), 1U);
  const auto& wanted = made.uncertainty.at(Structure::RvBlood);
  const auto& phases = again.at(Structure::RvBlood);
  ASSERT_EQ(phases.size(), wanted.size());
  for (std::size_t p = 0; p < wanted.size(); ++p) {
    ASSERT_EQ(phases[p].size(), wanted[p].size());
    for (std::size_t n = 0; n < wanted[p].size(); ++n) {
      EXPECT_EQ(phases[p][n].voxel, wanted[p][n].voxel);
      EXPECT_EQ(phases[p][n].sigma_mm, wanted[p][n].sigma_mm);
    }
  }
  EXPECT_TRUE(for_the_eye("segment/uncertainty_rv_blood.nii.gz"));
  EXPECT_FALSE(for_the_eye("segment/long_axis.json"));
}

TEST(StageFiles, LabelsAsAcquiredAreWrittenWhereThereAreAny) {
  const TemporaryFolder folder;
  const Segmentation made = make_segmentation();
  LabelCycle moved = made.labels;
  std::rotate(moved.phases.front().begin(), moved.phases.front().begin() + 1,
              moved.phases.front().end());
  const FileList files = write_segmentation(folder.path(), made, 0.05, moved);
  EXPECT_EQ(std::count(files.begin(), files.end(), kLabelsAsAcquired), 1);
  const LabelCycle again =
      read_labels(folder.path() / kLabelsAsAcquired, {moved.grid, moved.grid, moved.phase_count()});
  EXPECT_EQ(again.phases, moved.phases);
  EXPECT_EQ(read_segmentation(folder.path()).labels.phases, made.labels.phases);
  const TemporaryFolder other;
  const FileList without = write_segmentation(other.path(), made, 0.05);
  EXPECT_EQ(std::count(without.begin(), without.end(), kLabelsAsAcquired), 0);
  EXPECT_FALSE(fs::exists(other.path() / kLabelsAsAcquired));
  EXPECT_TRUE(for_the_eye(kLabelsAsAcquired));
}

TEST(StageFiles, AnImageOfAnotherPlaceOrSizeIsRefused) {
  const TemporaryFolder folder;
  const Segmentation segmentation = make_segmentation();
  (void)write_segmentation(folder.path(), segmentation, 0.05);
  Segmentation moved = segmentation;
  moved.labels.grid.mm_from_index.translation()[0] += 0.5;
  const TemporaryFolder other;
  (void)write_segmentation(other.path(), moved, 0.05);
  const auto swap_in = [&](const char* name) {
    fs::copy_file(other.path() / "segment" / name, folder.path() / "segment" / name,
                  fs::copy_options::overwrite_existing);
  };
  swap_in("labels.nii.gz");
  EXPECT_THROW((void)read_segmentation(folder.path()), Error);
  Segmentation shorter = segmentation;
  shorter.labels.phases.pop_back();
  (void)write_segmentation(other.path(), shorter, 0.05);
  swap_in("labels.nii.gz");
  EXPECT_THROW((void)read_segmentation(folder.path()), Error);
}

TEST(StageFiles, ARegistrationComesBackBitByBitAndLiesInThePatient) {
  const TemporaryFolder folder;
  Registration registration;
  registration.workspace_from_lps =
      Eigen::Translation3d(12.3, 1.0 / 3, 7) * Eigen::AngleAxisd(0.4, Vec3(3, 1, 2).normalized());
  Grid lattice{{6, 5, 4}, Affine::Identity()};
  lattice.mm_from_index.translation() = Vec3(100.1, 90.7, 80);
  registration.shapes = {{Structure::Heart, images(lattice, 3.7, false)},
                         {Structure::LvBlood, images(lattice, 2.1, false)}};
  LabelCycle labels{lattice, {}};
  labels.phases.assign(kPhases, std::vector<std::uint8_t>(lattice.count(), 3));
  (void)write_registration(folder.path(), registration.workspace_from_lps, registration.shapes,
                           images(lattice, 500, true), labels, 0.05);
  const Registration again = read_registration(folder.path());
  EXPECT_EQ(registration.workspace_from_lps.matrix(), again.workspace_from_lps.matrix());
  EXPECT_EQ(read_workspace_from_lps(folder.path()).matrix(), again.workspace_from_lps.matrix());
  ASSERT_EQ(again.shapes.size(), 2U);
  for (std::size_t at = 0; at < 2; ++at) {
    EXPECT_EQ(again.shapes[at].structure, registration.shapes[at].structure);
    expect_same(again.shapes[at].level, registration.shapes[at].level);
  }
}

TEST(StageFiles, SurfacesComeBackBitByBit) {
  const TemporaryFolder folder;
  SurfaceCycle surface{Structure::Heart, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, {}};
  for (int p = 0; p < kPhases; ++p) {
    surface.positions.push_back(
        {{0, 0, 0.1F * static_cast<float>(p)}, {1, 1.0F / 3, 0}, {0, 1, 0}, {0, 0, 9.87F}});
  }
  (void)write_surfaces(folder.path(), {surface});
  const std::vector<SurfaceCycle> again = read_surfaces(folder.path());
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].triangles, surface.triangles);
  EXPECT_EQ(again[0].positions, surface.positions);
  EXPECT_EQ(again[0].structure, surface.structure);
}

TEST(StageFiles, PhasesOfDifferentConnectivityAreRefused) {
  const TemporaryFolder folder;
  SurfaceCycle surface{Structure::Heart, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}, {}};
  surface.positions.assign(2, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  (void)write_surfaces(folder.path(), {surface});
  surface.triangles.push_back({0, 1, 2});
  const TemporaryFolder other;
  (void)write_surfaces(other.path(), {surface});
  fs::copy_file(other.path() / "mesh" / "heart_001.ply", folder.path() / "mesh" / "heart_001.ply",
                fs::copy_options::overwrite_existing);
  EXPECT_THROW((void)read_surfaces(folder.path()), Error);
}

FieldCycle make_field() {
  FieldCycle cycle;
  cycle.structure = Structure::LvBlood;
  cycle.voxel_mm = 1.5;
  cycle.inner_mm = 6;
  cycle.outer_mm = 4;
  Grid grid{{20, 18, 16}, Affine::Identity()};
  grid.mm_from_index.linear() = 1.5 * Eigen::Matrix3d::Identity();
  grid.mm_from_index.translation() = Vec3(100.5, 90, 70.5);
  cycle.distance_mm.grid = grid;
  for (int p = 0; p < kPhases; ++p) {
    const double radius = 8.0 + 0.3 * p;
    std::vector<float> distance(grid.count());
    for (int k = 0; k < 16; ++k) {
      for (int j = 0; j < 18; ++j) {
        for (int i = 0; i < 20; ++i) {
          const double d = (1.5 * Vec3(i - 9.5, j - 8.5, k - 7.5)).norm() - radius;
          distance[grid.offset(i, j, k)] = static_cast<float>(std::clamp(d, -6.0, 4.0));
        }
      }
    }
    cycle.distance_mm.phases.push_back(distance);
    cycle.volume_ml.push_back(4.0 / 3 * 3.14159 * std::pow(radius, 3) * 1e-3);
  }
  return cycle;
}

TEST(StageFiles, FieldsComeBackBitByBit) {
  const TemporaryFolder folder;
  const FieldCycle field = make_field();
  (void)write_fields(folder.path(), {field});
  const std::vector<FieldCycle> again = read_fields(folder.path());
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0].structure, field.structure);
  EXPECT_EQ(again[0].voxel_mm, field.voxel_mm);
  EXPECT_EQ(again[0].inner_mm, field.inner_mm);
  EXPECT_EQ(again[0].outer_mm, field.outer_mm);
  EXPECT_EQ(again[0].volume_ml, field.volume_ml);
  expect_same(again[0].distance_mm, field.distance_mm);
}

TEST(StageFiles, ADamagedIndexIsRefusedByItsPlace) {
  const TemporaryFolder folder;
  (void)write_fields(folder.path(), {make_field()});
  write_text(folder.path() / "field" / "field.json", R"({"structures": ["liver"]})");
  try {
    (void)read_fields(folder.path());
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    EXPECT_NE(std::string(error.what()).find("/structures"), std::string::npos);
  }
}

}  // namespace
}  // namespace beatlas::study
