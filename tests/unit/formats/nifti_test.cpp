#include "pipeline/formats/nifti.h"

#include <cmath>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "runtime/base/error.h"
#include "tests/unit/formats/python_run.h"

namespace beatlas::formats {
namespace {

using test::Folder;
using test::quoted;

const std::string kTool = std::string(BEATLAS_TEST_SCRIPTS) + "/nifti_tool.py";

/// The header keeps geometry as float32: 1e-7 of some hundred mm.
constexpr double kHeaderMm = 1e-4;

Affine lps_of(const nlohmann::json& ras_rows) {
  Affine out = Affine::Identity();
  for (int r = 0; r < 4; ++r) {
    for (int c = 0; c < 4; ++c) {
      const double sign = r < 2 ? -1 : 1;
      out.matrix()(r, c) =
          sign * ras_rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)].get<double>();
    }
  }
  out.matrix().row(3) << 0, 0, 0, 1;
  return out;
}

template <class T>
std::vector<double> flat(const ImageCycle<T>& images) {
  std::vector<double> out;
  for (const auto& phase : images.phases) out.insert(out.end(), phase.begin(), phase.end());
  return out;
}

nlohmann::json write_variant(const Folder& folder, const std::string& name,
                             const std::string& variant) {
  return test::run_python(kTool, "write " + quoted(folder / name) + ' ' + variant,
                          folder / "told.json");
}

nlohmann::json describe(const Folder& folder, const std::string& name) {
  return test::run_python(kTool, "describe " + quoted(folder / name), folder / "seen.json");
}

Grid oblique_grid(bool left_handed) {
  Grid out;
  out.size = {6, 5, 4};
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.4, Vec3(1, 2, 3).normalized()) *
                                Eigen::AngleAxisd(-1.1, Vec3(0.3, -1, 0.2).normalized()))
                                   .toRotationMatrix();
  out.mm_from_index.linear() = turn * Vec3(1.4, 1.6, left_handed ? -8 : 8).asDiagonal();
  out.mm_from_index.translation() = Vec3(-120.25, 33.5, 71.125);
  return out;
}

ImageCycle<float> random_cine(double low, double high, bool whole) {
  ImageCycle<float> out;
  out.grid = oblique_grid(false);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> value(low, high);
  for (int p = 0; p < 5; ++p) {
    std::vector<float> voxels(out.grid.count());
    for (float& v : voxels) {
      const double drawn = value(random);
      v = static_cast<float>(whole ? std::round(drawn) : drawn);
    }
    out.phases.push_back(voxels);
  }
  return out;
}

std::string failure(const Folder& folder, const std::string& name) {
  try {
    (void)read_nifti(folder / name);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << "names the file";
    return error.what();
  }
  return "no error";
}

class NiftiGeometryCases : public testing::TestWithParam<const char*> {};

TEST_P(NiftiGeometryCases, VoxelsLieWhereTheOtherToolPutThem) {
  const Folder folder;
  const auto told = write_variant(folder, "a.nii", GetParam());
  ImageFileHeader header;
  const auto images = read_nifti(folder / "a.nii", &header);
  EXPECT_TRUE(images.grid.mm_from_index.isApprox(lps_of(told["true_affine"]), 1e-5))
      << images.grid.mm_from_index.matrix();
  EXPECT_EQ(flat(images), told["values"].get<std::vector<double>>());
  const bool contradicts = std::string(GetParam()).find("1mm") != std::string::npos;
  EXPECT_EQ(!header.note.empty(), contradicts) << header.note;
}

INSTANTIATE_TEST_SUITE_P(Forms, NiftiGeometryCases,
                         testing::Values("plain", "qform_only", "sform_of_1mm",
                                         "sform_of_1mm_with_qform", "pixdim_of_1mm"));

TEST(Nifti, WithoutOrientationAxesAreRightAnteriorSuperior) {
  const Folder folder;
  write_variant(folder, "a.nii", "none");
  ImageFileHeader header;
  const auto images = read_nifti(folder / "a.nii", &header);
  Affine expected = Affine::Identity();
  expected.linear().diagonal() << -1.25, -1.5, 6.0;
  EXPECT_TRUE(images.grid.mm_from_index.isApprox(expected, 1e-6));
  EXPECT_NE(header.note.find("no orientation"), std::string::npos);
}

class NiftiTypes : public testing::TestWithParam<const char*> {};

TEST_P(NiftiTypes, ValuesAreThoseOfTheOtherTool) {
  const Folder folder;
  const auto told = write_variant(folder, "a.nii.gz", GetParam());
  const auto images = read_nifti(folder / "a.nii.gz");
  EXPECT_EQ(flat(images), told["values"].get<std::vector<double>>());
}

INSTANTIATE_TEST_SUITE_P(Types, NiftiTypes,
                         testing::Values("plain", "float32", "float64", "uint8", "int32",
                                         "big_endian", "slope"));

TEST(Nifti, TimeIsInSecondsWhateverTheUnit) {
  const Folder folder;
  for (const char* variant : {"plain", "msec"}) {
    write_variant(folder, "a.nii", variant);
    ImageFileHeader header;
    (void)read_nifti(folder / "a.nii", &header);
    EXPECT_EQ(header.frame_axis, FrameAxis::Time);
    EXPECT_NEAR(header.frame_interval_s, 0.15, 1e-7);
  }
  write_variant(folder, "b.nii", "no_unit");
  ImageFileHeader header;
  (void)read_nifti(folder / "b.nii", &header);
  EXPECT_EQ(header.frame_axis, FrameAxis::Untold);
  write_variant(folder, "c.nii", "three_d");
  EXPECT_EQ(read_nifti(folder / "c.nii", &header).phase_count(), 1);
  EXPECT_EQ(header.frame_axis, FrameAxis::Absent);
  EXPECT_EQ(header.frame_interval_s, 0);
}

TEST(Nifti, BadFilesAreRefusedWithTheirReason) {
  const Folder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"nan", "no numbers"},       {"rgb", "colour"},    {"five_d", "four dimensions"},
      {"sheared", "right angles"}, {"text", "no NIfTI"}, {"truncated", "truncated"}};
  for (const auto& [variant, reason] : cases) {
    for (const char* end : {".nii", ".nii.gz"}) {
      const std::string name = variant + std::string(end);
      if (std::string(variant) == "text" && std::string(end) == ".nii.gz") continue;
      write_variant(folder, name, variant);
      EXPECT_NE(failure(folder, name).find(reason), std::string::npos) << failure(folder, name);
    }
  }
  EXPECT_NE(failure(folder, "absent.nii").find("no such file"), std::string::npos);
}

TEST(Nifti, HeaderThatPromisesTooMuchIsRefusedBeforeMemoryIsTaken) {
  const Folder folder;
  write_variant(folder, "a.nii", "plain");
  std::fstream file(folder / "a.nii", std::ios::in | std::ios::out | std::ios::binary);
  const std::int16_t huge = 32000;
  for (const int at : {42, 44, 46}) {  // dim[1..3]
    file.seekp(at);
    file.write(reinterpret_cast<const char*>(&huge), sizeof(huge));
  }
  file.close();
  EXPECT_NE(failure(folder, "a.nii").find("truncated"), std::string::npos);
}

TEST(Nifti, WhatWeWriteIsWhatTheOtherToolReads) {
  const Folder folder;
  auto cine = random_cine(-200, 1500, true);
  for (const bool left_handed : {false, true}) {
    cine.grid = oblique_grid(left_handed);
    for (const char* name : {"a.nii", "a.nii.gz"}) {
      write_nifti(folder / name, cine, 0.0344, NiftiStorage::Int16);
      const auto seen = describe(folder, name);
      EXPECT_EQ(seen["shape"], nlohmann::json({6, 5, 4, 5}));
      EXPECT_EQ(seen["dtype"], "int16");
      EXPECT_EQ(seen["units"], nlohmann::json({"mm", "sec"}));
      EXPECT_NEAR(seen["zooms"][3].get<double>(), 0.0344, 1e-8);
      EXPECT_EQ(seen["values"].get<std::vector<double>>(), flat(cine));
      for (const char* form : {"affine", "qform"}) {
        const Affine lps = lps_of(seen[form]);
        EXPECT_LT((lps.matrix() - cine.grid.mm_from_index.matrix()).cwiseAbs().maxCoeff(),
                  kHeaderMm)
            << form;
      }
    }
  }
}

TEST(Nifti, StoragesKeepTheirPrecision) {
  const Folder folder;
  const auto small = random_cine(-0.5, 1.0, false);
  write_nifti(folder / "small.nii.gz", small, 0.03, NiftiStorage::Int16);
  const auto fraction = random_cine(0.0, 1.0, false);
  write_nifti(folder / "fraction.nii.gz", fraction, 0.03, NiftiStorage::UInt16Fraction);
  write_nifti(folder / "float.nii.gz", small, 0.03, NiftiStorage::Float32);
  const auto big = random_cine(0, 60000, true);
  write_nifti(folder / "big.nii.gz", big, 0.03, NiftiStorage::Int16);
  const auto worst = [&](const char* name, const ImageCycle<float>& truth) {
    const auto back = flat(read_nifti(folder / name));
    const auto seen = describe(folder, name)["values"].get<std::vector<double>>();
    const auto expected = flat(truth);
    double out = 0;
    for (std::size_t i = 0; i < back.size(); ++i) {
      out = std::max({out, std::abs(back[i] - expected[i]), std::abs(seen[i] - expected[i])});
    }
    return out;
  };
  EXPECT_LE(worst("small.nii.gz", small), 0.51 / 32767);  // half a step of the largest value
  EXPECT_LE(worst("fraction.nii.gz", fraction), 0.51 / 65535);
  EXPECT_EQ(worst("float.nii.gz", small), 0);
  EXPECT_LE(worst("big.nii.gz", big), 0.51 * 60000 / 32767);
}

TEST(Nifti, FullCoverageComesBackWhole) {
  const Folder folder;
  ImageCycle<float> ends;
  ends.grid = oblique_grid(false);
  ends.phases.assign(1, std::vector<float>(ends.grid.count(), 1.0F));
  ends.phases[0][7] = 0;
  write_nifti(folder / "ends.nii", ends, 0, NiftiStorage::UInt16Fraction);
  EXPECT_EQ(read_nifti(folder / "ends.nii").phases, ends.phases);
}

TEST(Nifti, SameImagesGiveTheSameBytes) {
  const Folder folder;
  const auto cine = random_cine(0, 1000, true);
  const auto bytes = [&](const std::string& name) {
    write_nifti(folder / name, cine, 0.03, NiftiStorage::Int16);
    std::ifstream in(folder / name, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string first = bytes("one.nii.gz");
  EXPECT_EQ(first, bytes("other_name.nii.gz"));
  ASSERT_GT(first.size(), 10U);
  EXPECT_EQ(first.substr(4, 4), std::string(4, '\0')) << "the time stamp of the gzip header";
}

TEST(Nifti, LabelsComeBackAndOtherValuesAreRefused) {
  const Folder folder;
  ImageCycle<std::uint8_t> labels;
  labels.grid = oblique_grid(true);
  for (int p = 0; p < 3; ++p) {
    std::vector<std::uint8_t> voxels(labels.grid.count());
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      voxels[i] = static_cast<std::uint8_t>((i * 7 + static_cast<std::size_t>(p)) % 5);
    }
    labels.phases.push_back(voxels);
  }
  write_nifti_labels(folder / "l.nii.gz", labels, 0.03);
  EXPECT_EQ(read_nifti_labels(folder / "l.nii.gz").phases, labels.phases);
  EXPECT_EQ(describe(folder, "l.nii.gz")["dtype"], "uint8");
  write_variant(folder, "image.nii", "plain");  // has values below 0 and above 255
  EXPECT_THROW((void)read_nifti_labels(folder / "image.nii"), Error);
}

TEST(Nifti, UnwritablePlaceIsMachineTrouble) {
  const auto cine = random_cine(0, 10, true);
  try {
    write_nifti("/proc/none/a.nii.gz", cine, 0.1, NiftiStorage::Int16);
    FAIL() << "wrote";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Machine);
  }
  EXPECT_THROW(write_nifti("a.img", cine, 0.1, NiftiStorage::Int16), Error);
}

}  // namespace
}  // namespace beatlas::formats
