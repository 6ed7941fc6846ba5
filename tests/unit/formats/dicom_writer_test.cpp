#include "pipeline/formats/dicom_writer.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <set>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/formats/python_run.h"

namespace beatlas::formats {
namespace {

using test::Folder;

Cine cine_of(float low) {
  Cine out;
  out.images.grid.size = {7, 5, 4};
  out.images.grid.mm_from_index.linear() =
      (Eigen::AngleAxisd(0.7, Vec3(1, 2, -3).normalized()).toRotationMatrix() *
       Vec3(1.367231234567, 1.25, 7.7).asDiagonal());
  out.images.grid.mm_from_index.translation() = Vec3(-101.123456789012, 33.3333333333333, -7e-3);
  out.rr_interval_s = 0.9337;
  for (int p = 0; p < 6; ++p) {
    std::vector<float> voxels(out.images.grid.count());
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      voxels[i] = low + static_cast<float>(i * 13 % 997) + 0.25F * static_cast<float>(p);
    }
    out.images.phases.push_back(voxels);
    out.frame_times_s.push_back(out.rr_interval_s * p / 6);
  }
  return out;
}

nlohmann::json seen_in(const Folder& folder, const std::string& name) {
  return test::run_python(std::string(BEATLAS_TEST_SCRIPTS) + "/dicom_describe.py",
                          test::quoted(folder / name), folder / (name + ".json"));
}

TEST(DicomWriter, AnotherReaderSeesTheSamePixelsGeometryAndTimes) {
  const Folder folder;
  for (const float low : {0.0F, -500.0F}) {
    const Cine cine = cine_of(low);
    const Grid& grid = cine.grid();
    const std::string name = low < 0 ? "signed" : "unsigned";
    write_dicom(folder / name, cine);
    const auto seen = seen_in(folder, name);
    ASSERT_EQ(seen.size(), 24U);
    std::map<std::string, int> files_of_series;
    std::set<std::string> instances;
    for (const auto& image : seen) {
      ++files_of_series[image["series"].get<std::string>()];
      instances.insert(image["instance"].get<std::string>());
      EXPECT_EQ(image["instance"], image["meta_instance"]);
      EXPECT_EQ(image["class"], "1.2.840.10008.5.1.4.1.1.4");
      EXPECT_EQ(image["syntax"], "1.2.840.10008.1.2.1");
      EXPECT_EQ(image["rr_ms"], 934);
      EXPECT_EQ(image["number_of_images"], 6);
      EXPECT_LE(image["longest_ds"].get<int>(), 16);
      const auto position = image["position"].get<std::vector<double>>();
      const Vec3 index = grid.mm_from_index.inverse() * Vec3(position[0], position[1], position[2]);
      const int k = static_cast<int>(std::lround(index[2]));
      EXPECT_LT((index - Vec3(0, 0, k)).norm(), 1e-10) << "16 characters of a decimal string";
      const auto spacing = image["spacing"].get<std::vector<double>>();
      const auto direction = image["orientation"].get<std::vector<double>>();
      const Vec3 row(direction[0], direction[1], direction[2]);
      const Vec3 column(direction[3], direction[4], direction[5]);
      EXPECT_LT((row * spacing[1] - grid.mm_from_index.linear().col(0)).norm(), 1e-11);
      EXPECT_LT((column * spacing[0] - grid.mm_from_index.linear().col(1)).norm(), 1e-11);
      const double phase = image["trigger_ms"].get<double>() / (cine.rr_interval_s * 1e3) * 6;
      const int p = static_cast<int>(std::lround(phase));
      EXPECT_NEAR(phase, p, 1e-9);
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const float value = cine.images.phases[static_cast<std::size_t>(p)][grid.offset(i, j, k)];
          EXPECT_EQ(image["pixels"][static_cast<std::size_t>(j)][static_cast<std::size_t>(i)],
                    std::lround(value));
        }
      }
    }
    EXPECT_EQ(instances.size(), 24U);
    EXPECT_EQ(files_of_series.size(), 4U);
  }
}

TEST(DicomWriter, OneSeriesHoldsAllSlicesIfAsked) {
  const Folder folder;
  write_dicom(folder / "one", cine_of(0), {.series_per_slice = false});
  std::set<std::string> series;
  for (const auto& image : seen_in(folder, "one")) series.insert(image["series"]);
  EXPECT_EQ(series.size(), 1U);
}

TEST(DicomWriter, UidsComeFromTheContentAndAreValid) {
  const Folder folder;
  const auto uids = [&](const std::string& name) {
    std::set<std::string> out;
    for (const auto& image : seen_in(folder, name)) {
      out.insert(image["instance"]);
      out.insert(image["series"]);
      out.insert(image["study"]);
    }
    return out;
  };
  Cine cine = cine_of(0);
  write_dicom(folder / "a", cine);
  write_dicom(folder / "b", cine);
  cine.images.phases[2][11] += 1;
  write_dicom(folder / "c", cine);
  EXPECT_EQ(uids("a"), uids("b"));
  const auto a = uids("a");
  const std::string root = "2.25.";
  for (const std::string& uid : uids("c")) {
    EXPECT_EQ(a.count(uid), 0U) << "another content has other UIDs";
    ASSERT_EQ(uid.rfind(root, 0), 0U) << uid;
    const std::string number = uid.substr(root.size());
    EXPECT_EQ(number.find_first_not_of("0123456789"), std::string::npos) << uid;
    EXPECT_TRUE(number.size() <= 39 && number.front() != '0') << "a number of 128 bits: " << uid;
  }
  const auto bytes = [&](const std::string& name) {
    std::ifstream in(folder / name / "slice_002" / "phase_003.dcm", std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  EXPECT_FALSE(bytes("a").empty());
  EXPECT_EQ(bytes("a"), bytes("b"));
}

TEST(DicomWriter, WhatDicomCannotHoldIsRefused) {
  const Folder folder;
  Cine cine = cine_of(0);
  cine.images.phases[0][0] = 70000;
  EXPECT_THROW(write_dicom(folder / "a", cine), Error);
  cine = cine_of(0);
  cine.images.grid.mm_from_index.linear().col(1) += Vec3(0.1, 0.1, 0.1);
  EXPECT_THROW(write_dicom(folder / "a", cine), Error);
  cine = cine_of(0);
  cine.rr_interval_s = 0;
  EXPECT_THROW(write_dicom(folder / "a", cine), Error);
  try {
    write_dicom("/proc/none", cine_of(0));
    FAIL() << "wrote";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Machine);
  }
}

}  // namespace
}  // namespace beatlas::formats
