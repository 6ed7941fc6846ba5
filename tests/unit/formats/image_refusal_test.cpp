// What image files must not get away with, and what they say of their frames.

#include <fstream>
#include <limits>

#include <gtest/gtest.h>

#include "pipeline/formats/grid_axes.h"
#include "pipeline/formats/image_file.h"
#include "runtime/base/error.h"
#include "tests/unit/formats/image_bytes.h"
#include "tests/unit/formats/python_run.h"

namespace beatlas::formats {
namespace {

using namespace beatlas::test;

std::string with(std::string text, const std::string& old, const std::string& now) {
  const auto at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), now);
}

std::string small_nrrd(int frames = 10, bool first = false) {
  const Beating object = oblique_object();
  return nrrd_header(object.grid, frames, first) + "encoding: raw\n\n" +
         stored(object.voxels(), "i2");
}
std::string small_meta(const std::string& more = "") {
  const Beating object = oblique_object();
  return meta_header(object.grid, object.frames) + more + "ElementDataFile = LOCAL\n" +
         stored(object.voxels(), "i2");
}
std::string small_nifti(const std::function<void(std::string&)>& change = {}) {
  const Beating object = oblique_object();
  return nifti_header(object.grid, object.frames, {.change = change}) +
         stored(object.voxels(), "i2");
}

ImageFile read(const std::string& name, const std::string& bytes) {
  const Folder folder;
  std::ofstream(folder / name, std::ios::binary) << bytes;
  return read_image_file(folder / name);
}

std::string refusal(const std::string& name, const std::string& bytes) {
  try {
    (void)read(name, bytes);
  } catch (const Error& error) {
    const std::string message = error.what();
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    EXPECT_NE(message.find(name + ": "), std::string::npos) << message;
    EXPECT_EQ(message.find("SECRET"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  }
  return "was read";
}

struct Case {
  const char* what;
  const char* name;
  std::function<std::string()> bytes;
  const char* reason;
};
void PrintTo(const Case& bad, std::ostream* out) { *out << bad.what; }

std::vector<Case> cases() {
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  return {
      {"nrrd_text", "a.nrrd", [] { return std::string("some SECRET text\n"); }, "no NRRD file"},
      {"nrrd_empty", "a.nrrd", [] { return std::string(); }, "no NRRD file"},
      {"nrrd_cut", "a.nrrd", [] { return small_nrrd().substr(0, 5000); }, "truncated"},
      {"nrrd_cut_gzip", "a.nrrd",
       [] {
         const std::string whole = small_nrrd();
         const auto at = whole.find("\n\n") + 2;
         const std::string packed = gzip(whole.substr(at));
         return with(whole.substr(0, at), "raw", "gzip") + packed.substr(0, packed.size() / 2);
       },
       "truncated"},
      {"nrrd_damaged_gzip", "a.nrrd",
       [] {
         const std::string whole = small_nrrd();
         const auto at = whole.find("\n\n") + 2;
         std::string packed = gzip(whole.substr(at));
         packed[packed.size() / 2] ^= 0x55;
         return with(whole.substr(0, at), "raw", "gzip") + packed;
       },
       "damaged"},
      {"nrrd_wrong_check_sum", "a.nrrd",
       [] {
         const std::string whole = small_nrrd();
         const auto at = whole.find("\n\n") + 2;
         std::string packed = gzip(whole.substr(at));
         packed[packed.size() - 6] ^= 0x55;
         return with(whole.substr(0, at), "raw", "gzip") + packed;
       },
       "damaged"},
      {"nrrd_cut_bzip2", "a.nrrd",
       [] {
         const std::string whole = small_nrrd();
         const auto at = whole.find("\n\n") + 2;
         const std::string packed = bzip2(whole.substr(at));
         return with(whole.substr(0, at), "raw", "bzip2") + packed.substr(0, packed.size() / 2);
       },
       "truncated"},
      {"nrrd_promises_too_much", "a.nrrd",
       [] { return with(small_nrrd(), "20 16 6 10", "20000 20000 20000 100"); }, "truncated"},
      {"nrrd_overflows", "a.nrrd",
       [] {
         return with(small_nrrd(), "20 16 6 10", "2147483647 2147483647 2147483647 2147483647");
       },
       "truncated"},
      {"nrrd_size_zero", "a.nrrd", [] { return with(small_nrrd(), "20 16 6", "20 0 6"); }, "sizes"},
      {"nrrd_size_negative", "a.nrrd", [] { return with(small_nrrd(), "20 16", "20 -16"); },
       "sizes"},
      {"nrrd_five_axes", "a.nrrd",
       [] {
         return std::string(
             "NRRD0001\ntype: uchar\ndimension: 5\nsizes: 1 1 1 1 1\nencoding: raw\n\nx");
       },
       "more than four"},
      {"nrrd_flat", "a.nrrd",
       [] {
         return std::string("NRRD0001\ntype: uchar\ndimension: 2\nsizes: 1 1\nencoding: raw\n\nx");
       },
       "fewer than three"},
      {"nrrd_colour", "a.nrrd",
       [] {
         return std::string(
             "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 3 1 1\nkinds: RGB-color domain domain\n"
             "encoding: raw\n\nabc");
       },
       "colour"},
      {"nrrd_block", "a.nrrd", [] { return with(small_nrrd(), "type: short", "type: block"); },
       "blocks"},
      {"nrrd_unknown_space", "a.nrrd",
       [] { return with(small_nrrd(), "left-posterior-superior", "SECRET"); }, "space"},
      {"nrrd_no_endian", "a.nrrd", [] { return with(small_nrrd(), "endian: little\n", ""); },
       "endian"},
      {"nrrd_no_spacing", "a.nrrd",
       [] {
         return std::string(
             "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n\nx");
       },
       "no usable voxel size"},
      {"nrrd_spacing_negative", "a.nrrd",
       [] {
         return std::string(
             "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nspacings: 1 -1 1\n"
             "encoding: raw\n\nx");
       },
       "no usable voxel size"},
      {"nrrd_spacing_nan", "a.nrrd",
       [] {
         return std::string(
             "NRRD0001\ntype: uchar\ndimension: 3\nsizes: 1 1 1\nspacings: 1 nan 1\n"
             "encoding: raw\n\nx");
       },
       "no usable voxel size"},
      {"nrrd_direction_zero", "a.nrrd",
       [] {
         const Beating object = oblique_object();
         return with(small_nrrd(), nrrd_vector(object.grid.mm_from_index.linear().col(2)),
                     "(0,0,0)");
       },
       "voxel size"},
      {"nrrd_sheared", "a.nrrd",
       [] {
         Beating object = oblique_object();
         object.grid.mm_from_index.linear().col(1) +=
             0.1 * object.grid.mm_from_index.linear().col(0);
         return nrrd_header(object.grid, 10) + "encoding: raw\n\n" + stored(object.voxels(), "i2");
       },
       "right angles"},
      {"nrrd_hex", "a.nrrd", [] { return with(small_nrrd(), "encoding: raw", "encoding: hex"); },
       "encoding"},
      {"nrrd_data_elsewhere", "a.nhdr",
       [] { return with(small_nrrd(), "endian", "data file: SECRET.raw\nendian"); },
       "not where it says"},
      {"nrrd_data_of_the_machine", "a.nhdr",
       [] { return with(small_nrrd(), "endian", "data file: /etc/passwd\nendian"); },
       "outside the header's folder"},
      {"meta_data_of_the_machine", "a.mhd",
       [] { return with(small_meta(), "LOCAL", "/etc/passwd"); }, "outside the header's folder"},
      {"nrrd_data_pattern", "a.nhdr",
       [] { return with(small_nrrd(), "endian", "data file: %s%d%n.raw 1 2 1\nendian"); },
       "pattern"},
      {"nrrd_infinite", "a.nrrd",
       [] {
         return std::string(
             "NRRD0001\ntype: double\ndimension: 3\nsizes: 1 1 1\nspacings: 1 1 1\n"
             "encoding: ascii\n\ninf");
       },
       "no numbers"},
      {"nrrd_word_among_numbers", "a.nrrd",
       [] {
         return std::string(
             "NRRD0001\ntype: double\ndimension: 3\nsizes: 1 1 1\nspacings: 1 1 1\n"
             "encoding: ascii\n\nSECRET");
       },
       "a word that is no number"},
      {"meta_text", "a.mha", [] { return std::string("some SECRET text\n"); }, "no MetaImage"},
      {"meta_cut", "a.mha", [] { return small_meta().substr(0, 9000); }, "truncated"},
      {"meta_cut_packed", "a.mha",
       [] {
         const Beating object = oblique_object();
         const std::string packed = zlib(stored(object.voxels(), "i2"));
         return meta_header(object.grid, 10) + "CompressedData = True\nElementDataFile = LOCAL\n" +
                packed.substr(0, packed.size() - 50);
       },
       "truncated"},
      {"meta_size_negative", "a.mha", [] { return with(small_meta(), "= 20 16", "= -20 16"); },
       "DimSize"},
      {"meta_promises_too_much", "a.mha",
       [] { return with(small_meta(), "= 20 16", "= 200000 160000"); }, "truncated"},
      {"meta_spacing_zero", "a.mha",
       [] { return with(small_meta(), "ElementSpacing = 4", "ElementSpacing = 0"); },
       "zero, negative or no number"},
      {"meta_spacing_nan", "a.mha",
       [] { return with(small_meta(), "ElementSpacing = 4", "ElementSpacing = nan"); },
       "zero, negative or no number"},
      {"meta_no_spacing", "a.mha", [] { return with(small_meta(), "ElementSpacing", "Spacing"); },
       "ElementSpacing"},
      {"meta_channels", "a.mha", [] { return small_meta("ElementNumberOfChannels = 3\n"); },
       "several values"},
      {"meta_array", "a.mha", [] { return with(small_meta(), "MET_SHORT", "MET_SHORT_ARRAY"); },
       "ElementType"},
      {"meta_dimensions", "a.mha", [] { return with(small_meta(), "NDims = 4", "NDims = 30"); },
       "more than four"},
      {"meta_time_in_space", "a.mha",
       [] { return with(small_meta(), " 0 0 0 1\n", " 0.5 0 0 1\n"); }, "space and time"},
      {"nifti_text", "a.nii", [] { return std::string(1000, 'S'); }, "no NIfTI"},
      {"nifti_short", "a.nii", [] { return small_nifti().substr(0, 200); }, "no NIfTI"},
      {"nifti_empty", "a.nii", [] { return std::string(); }, "empty"},
      {"nifti_cut", "a.nii", [] { return small_nifti().substr(0, 9000); }, "truncated"},
      {"nifti_cut_packed", "a.nii.gz",
       [] {
         const std::string packed = gzip(small_nifti());
         return packed.substr(0, packed.size() * 2 / 3);
       },
       "truncated"},
      {"nifti_analyze", "a.hdr",
       [] { return small_nifti([](std::string& h) { h.replace(344, 4, 4, '\0'); }); }, "Analyze"},
      {"nifti_pair_without_voxels", "a.hdr",
       [] { return small_nifti([](std::string& h) { h.replace(344, 3, "ni1"); }); },
       "(.img) that belong"},
      {"nifti_img_without_header", "a.img", [] { return small_nifti(); }, "(.hdr) that belongs"},
      {"nifti_dim_zero", "a.nii",
       [] { return small_nifti([](std::string& h) { put<std::int16_t>(h, 44, 0); }); },
       "without voxels"},
      {"nifti_dim_negative", "a.nii",
       [] { return small_nifti([](std::string& h) { put<std::int16_t>(h, 44, -16); }); },
       "without voxels"},
      {"nifti_five_axes", "a.nii",
       [] {
         return small_nifti([](std::string& h) {
           put<std::int16_t>(h, 40, 5);
           put<std::int16_t>(h, 50, 3);
         });
       },
       "more than four"},
      {"nifti_colour", "a.nii",
       [] { return small_nifti([](std::string& h) { put<std::int16_t>(h, 70, 128); }); }, "colour"},
      {"nifti_complex", "a.nii",
       [] { return small_nifti([](std::string& h) { put<std::int16_t>(h, 70, 32); }); }, "complex"},
      {"nifti_no_size", "a.nii",
       [] {
         return small_nifti([](std::string& h) {
           put<float>(h, 80, -4.0F);
           put<std::int16_t>(h, 254, 0);
         });
       },
       "voxel size"},
      {"nifti_size_nan", "a.nii",
       [nan] {
         return small_nifti([nan](std::string& h) {
           put<float>(h, 80, nan);
           put<std::int16_t>(h, 254, 0);
         });
       },
       "voxel size"},
      {"unknown_end", "a.png", [] { return small_nifti(); }, "no image file"},
  };
}

class Refusals : public testing::TestWithParam<Case> {};
TEST_P(Refusals, AreOneSentenceThatNamesTheFile) {
  const std::string message = refusal(GetParam().name, GetParam().bytes());
  EXPECT_NE(message, "was read");
  EXPECT_NE(message.find(GetParam().reason), std::string::npos) << message;
}
INSTANTIATE_TEST_SUITE_P(All, Refusals, testing::ValuesIn(cases()),
                         [](const auto& test) { return std::string(test.param.what); });

TEST(NiftiHeader, ScalingOfZeroOrNoNumberIsNone) {
  const auto first = [](double slope, double intercept) {
    const Beating object = oblique_object();
    return read("a.nii", nifti_header(object.grid, 10, {.slope = slope, .intercept = intercept}) +
                             stored(object.voxels(), "i2"))
        .images.phases[0][0];
  };
  const float plain = first(0, 7);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(plain, oblique_object().voxels()[0]);
  EXPECT_EQ(first(nan, 7), plain);
  EXPECT_EQ(first(1, nan), plain);
  EXPECT_EQ(first(std::numeric_limits<double>::infinity(), 0), plain);
  EXPECT_EQ(first(0.5, -10), plain * 0.5F - 10);
}

TEST(NiftiHeader, PixdimIsUsedUnlessTheSformIsTheOneThatKnows) {
  const auto spacing = [](const std::function<void(std::string&)>& change, std::string& note) {
    const ImageFile file = read("a.nii", small_nifti(change));
    note = file.header.note;
    return file.images.grid.spacing_mm();
  };
  const auto sform_of_1mm = [](std::string& h) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        put<float>(h, static_cast<std::size_t>(280 + 16 * r + 4 * c), r == c ? 1.0F : 0.0F);
      }
    }
  };
  const auto no_qform = [](std::string& h) { put<std::int16_t>(h, 252, 0); };
  const auto pixdim_of_1mm = [](std::string& h) {
    for (std::size_t at : {80U, 84U, 88U}) put<float>(h, at, 1.0F);
  };
  const Vec3 right(4.0, 4.5, 8.0);
  std::string note;
  EXPECT_TRUE(spacing(sform_of_1mm, note).isApprox(right, 1e-6));
  EXPECT_NE(note.find("the qform was taken"), std::string::npos);
  EXPECT_TRUE(
      spacing([&](std::string& h) { sform_of_1mm(h), no_qform(h); }, note).isApprox(right, 1e-6));
  EXPECT_NE(note.find("its directions were taken"), std::string::npos);
  EXPECT_TRUE(spacing(pixdim_of_1mm, note).isApprox(right, 1e-6));
  EXPECT_NE(note.find("pixdim was left at 1 mm"), std::string::npos);
}

TEST(NiftiHeader, FourthAxisMayBeSomethingElse) {
  const auto axis = [](int units, int intent) {
    return read("a.nii", small_nifti([&](std::string& h) {
                  h[123] = static_cast<char>(units);
                  put<std::int16_t>(h, 68, static_cast<std::int16_t>(intent));
                }))
        .header;
  };
  EXPECT_EQ(axis(2 | 8, 0).frame_axis, FrameAxis::Time);
  EXPECT_EQ(axis(2 | 8, 2001).frame_axis, FrameAxis::Time);
  EXPECT_EQ(axis(2, 0).frame_axis, FrameAxis::Untold);
  for (const int units : {32, 40, 48}) {
    EXPECT_EQ(axis(2 | units, 0).frame_axis, FrameAxis::Other);
    EXPECT_FALSE(axis(2 | units, 0).frame_axis_is.empty());
  }
  for (const int intent : {3, 1004, 1007, 2003, 2006}) {
    EXPECT_EQ(axis(2 | 8, intent).frame_axis, FrameAxis::Other) << intent;
  }
}

ImageFileHeader nrrd_frames(const std::string& fields) {
  return read("a.nrrd", with(small_nrrd(), "endian", fields + "endian")).header;
}

TEST(NrrdHeader, FramesAreWhatTheFileSays) {
  EXPECT_EQ(nrrd_frames("").frame_axis, FrameAxis::Untold);
  EXPECT_EQ(nrrd_frames("kinds: domain domain domain list\n").frame_axis, FrameAxis::Untold);

  auto told = nrrd_frames(
      "kinds: space space space time\nspacings: nan nan nan 90\n"
      "units: \"\" \"\" \"\" \"ms\"\n");
  EXPECT_EQ(told.frame_axis, FrameAxis::Time);
  EXPECT_TRUE(told.unit_known);
  EXPECT_NEAR(told.frame_interval_s, 0.09, 1e-12);

  told = nrrd_frames("spacings: nan nan nan 0.09\nkinds: domain domain domain time\n");
  EXPECT_EQ(told.frame_axis, FrameAxis::Time);
  EXPECT_FALSE(told.unit_known);

  told = nrrd_frames(
      "labels: \"\" \"\" \"\" \"time\"\nunits: \"\" \"\" \"\" \"s\"\n"
      "axis 3 index type:=numeric\n"
      "axis 3 index values:=0 0.1 0.2 0.3 0.4 0.5 0.6 0.7 0.75 0.8\n");
  EXPECT_EQ(told.frame_axis, FrameAxis::Time);
  ASSERT_EQ(told.frame_times_s.size(), 10U);
  EXPECT_EQ(told.frame_times_s[8], 0.75);

  told = nrrd_frames(
      "MultiVolume.FrameIdentifyingDICOMTagName:=TriggerTime\n"
      "MultiVolume.FrameIdentifyingDICOMTagUnits:=ms\n"
      "MultiVolume.FrameLabels:=0,90,180,270,360,450,540,630,720,810\n");
  ASSERT_EQ(told.frame_times_s.size(), 10U);
  EXPECT_NEAR(told.frame_times_s[9], 0.81, 1e-12);

  for (const char* kind : {"vector", "RGB-color", "complex", "3D-symmetric-matrix"}) {
    EXPECT_EQ(nrrd_frames(std::string("kinds: domain domain domain ") + kind + "\n").frame_axis,
              FrameAxis::Other)
        << kind;
  }
  EXPECT_EQ(nrrd_frames("modality:=DWMRI\nDWMRI_b-value:=1000\n").frame_axis, FrameAxis::Other);
  // Images that differ by an angle.
  told = nrrd_frames("units: \"\" \"\" \"\" \"deg\"\naxis 3 index values:=1 2 3 4 5 6 7 8 9 10\n");
  EXPECT_EQ(told.frame_axis, FrameAxis::Untold);
  EXPECT_TRUE(told.frame_times_s.empty());
}

TEST(NrrdHeader, SpaceWithTimeGivesTheInterval) {
  std::string text = small_nrrd();
  text = with(text, "left-posterior-superior", "left-posterior-superior-time");
  text = with(text, " none", " (0,0,0,90)");
  for (std::size_t at = text.find("directions:"); at < text.find("endian");) {
    at = text.find(')', at);
    if (at > text.find("endian")) break;
    if (text.compare(at - 3, 3, ",90") != 0) text.insert(at, ",0");
    at += 3;
  }
  text = with(text, "endian", "space units: \"mm\" \"mm\" \"mm\" \"ms\"\nendian");
  const ImageFile file = read("a.nrrd", text);
  EXPECT_EQ(file.header.frame_axis, FrameAxis::Time);
  EXPECT_NEAR(file.header.frame_interval_s, 0.09, 1e-12);
  EXPECT_TRUE(file.images.grid.mm_from_index.isApprox(oblique_object().grid.mm_from_index, 1e-9));
}

TEST(NrrdHeader, SpaceThatNamesNoAnatomyIsTakenAsLpsAndTold) {
  const ImageFile file =
      read("a.nrrd", with(small_nrrd(), "left-posterior-superior", "scanner-xyz"));
  EXPECT_TRUE(file.images.grid.mm_from_index.isApprox(oblique_object().grid.mm_from_index, 1e-9));
  EXPECT_NE(file.header.note.find("no anatomical space"), std::string::npos);
}

TEST(MetaImageHeader, IntervalHasNoUnit) {
  const ImageFileHeader told = read("a.mha", small_meta()).header;
  EXPECT_EQ(told.frame_axis, FrameAxis::Untold);
  EXPECT_FALSE(told.unit_known);
  EXPECT_NEAR(told.frame_interval_s, 0.09, 1e-12);
}

TEST(MetaImageHeader, IntensityFunctionIsApplied) {
  const ImageFile file = read("a.mha", small_meta("ElementToIntensityFunctionSlope = 0.5\n"
                                                  "ElementToIntensityFunctionOffset = -10\n"));
  EXPECT_EQ(file.images.phases[0][0], oblique_object().voxels()[0] * 0.5 - 10);
}

TEST(GridAxes, SlightSkewIsRepairedAndTold) {
  const Affine right = oblique_object().grid.mm_from_index;
  Affine skewed = right;
  skewed.linear().col(1) += 0.002 * skewed.linear().col(0);
  std::string note;
  const Affine repaired = checked_axes(skewed, note);
  EXPECT_NE(note.find("right angles"), std::string::npos);
  const Eigen::Matrix3d unit = repaired.linear().colwise().normalized();
  EXPECT_TRUE((unit.transpose() * unit).isApprox(Eigen::Matrix3d::Identity(), 1e-12));
  EXPECT_TRUE(repaired.isApprox(right, 2e-3));

  note.clear();
  EXPECT_EQ(checked_axes(right, note).matrix(), right.matrix());
  EXPECT_TRUE(note.empty());
}

}  // namespace
}  // namespace beatlas::formats
