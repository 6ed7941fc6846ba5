// One object in every form that files give it: each must come back with its voxels in their place.

#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "pipeline/formats/image_file.h"
#include "runtime/base/error.h"
#include "tests/unit/formats/image_bytes.h"
#include "tests/unit/formats/python_run.h"

namespace beatlas::formats {
namespace {

using namespace beatlas::test;
namespace fs = std::filesystem;

/// Numbers of 1000 grey levels a mm at most; half a grey level is rounding.
constexpr double kRounding = 0.51;
/// NIfTI-1 keeps geometry as float32.
constexpr double kPlaceMm = 1e-4;

void write(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

/// A way to write an object; the file to read.
struct Form {
  std::string name;
  std::function<fs::path(const Folder&, const Beating&)> write;
  bool left_handed = false;
};
void PrintTo(const Form& form, std::ostream* out) { *out << form.name; }

Form nifti(const std::string& name, NiftiForm form, const std::string& file, bool packed = false) {
  return {name, [=](const Folder& folder, const Beating& object) {
            const std::string header = nifti_header(object.grid, object.frames, form);
            const std::string voxels = stored(object.voxels(), form.type, form.big_endian);
            const auto pack = [&](const std::string& bytes) {
              return packed ? gzip(bytes) : bytes;
            };
            if (form.pair) {
              write(folder / (file + ".hdr"), header);
              write(folder / (file + (packed ? ".img.gz" : ".img")), pack(voxels));
              return folder / (file + ".hdr");
            }
            write(folder / file, pack(header + voxels));
            return folder / file;
          }};
}

Form nrrd(const std::string& name, bool first, const std::string& space, const std::string& type,
          const std::string& encoding) {
  return {name, [=](const Folder& folder, const Beating& object) {
            std::string bytes =
                nrrd_header(object.grid, object.frames, first, space,
                            type == "f8" ? "double" : (type == "u2" ? "uint16_t" : "short")) +
                "encoding: " + encoding + "\n\n";
            auto values = object.voxels();
            if (first) values = frames_first(values, object.frames);
            std::string data = stored(values, encoding == "ascii" ? "text" : type);
            if (encoding == "gzip") data = gzip(data);
            if (encoding == "bzip2") data = bzip2(data);
            write(folder / "a.nrrd", bytes + data);
            return folder / "a.nrrd";
          }};
}

/// A header beside its data; `lines` end the header.
Form detached(const std::string& name, const std::string& header_name, const std::string& lines,
              int files, const std::string& before = "") {
  return {name, [=](const Folder& folder, const Beating& object) {
            const bool is_nrrd = header_name.ends_with(".nhdr");
            write(folder / header_name, (is_nrrd ? nrrd_header(object.grid, object.frames)
                                                 : meta_header(object.grid, object.frames)) +
                                            lines);
            const std::string data = stored(object.voxels(), "i2");
            const std::size_t part = data.size() / static_cast<std::size_t>(files);
            for (int f = 0; f < files; ++f) {
              const std::string end = files > 1 ? std::to_string(f + 1) : "";
              write(folder / ("part" + end + ".raw"),
                    before + data.substr(static_cast<std::size_t>(f) * part, part));
            }
            return folder / header_name;
          }};
}

Form meta(const std::string& name, const std::string& more, const std::string& type) {
  return {name, [=](const Folder& folder, const Beating& object) {
            const bool packed = more.find("CompressedData = True") != std::string::npos;
            const bool big = more.find("MSB = True") != std::string::npos;
            std::string data = stored(object.voxels(), type, big);
            if (packed) data = zlib(data);
            const char* kind = type == "f4" ? "MET_FLOAT" : "MET_SHORT";
            write(folder / "a.mha", meta_header(object.grid, object.frames, kind) + more +
                                        "ElementDataFile = LOCAL\n" + data);
            return folder / "a.mha";
          }};
}

std::string names_of_parts(int count) {
  std::string out;
  for (int f = 1; f <= count; ++f) out += "part" + std::to_string(f) + ".raw\n";
  return out;
}

Form left(Form form) {
  form.name += "_left_handed";
  form.left_handed = true;
  return form;
}

std::vector<Form> forms() {
  std::vector<Form> out{
      nifti("nifti1", {}, "a.nii"),
      left(nifti("nifti1", {}, "a.nii")),
      left(nifti("nifti1_by_quaternion", {.sform = false}, "a.nii")),
      nifti("nifti1_by_quaternion_alone", {.sform = false}, "a.nii"),
      nifti("nifti1_by_sform_alone", {.qform = false}, "a.nii"),
      nifti("nifti1_packed", {}, "a.nii.gz", true),
      nifti("nifti1_packed_under_a_plain_name", {}, "a.nii", true),
      nifti("nifti1_plain_under_a_packed_name", {}, "a.nii.gz"),
      nifti("nifti1_big_endian", {.big_endian = true, .type = "f8"}, "a.NII"),
      nifti("nifti1_pair", {.pair = true}, "a"),
      nifti("nifti1_pair_packed", {.pair = true, .type = "u2"}, "a", true),
      nifti("nifti2", {.version = 2}, "a.nii"),
      nifti("nifti2_big_endian", {.version = 2, .big_endian = true, .type = "i4"}, "a.nii.gz",
            true),
      left(nifti("nifti2_pair", {.version = 2, .pair = true}, "a")),
      nrrd("nrrd_lps", false, "left-posterior-superior", "i2", "raw"),
      left(nrrd("nrrd_lps", true, "LPS", "i2", "raw")),
      nrrd("nrrd_ras_list_first_gzip", true, "right-anterior-superior", "u2", "gzip"),
      nrrd("nrrd_las_bzip2", false, "left-anterior-superior", "f8", "bzip2"),
      nrrd("nrrd_ascii", true, "RAS", "i2", "ascii"),
      detached("nhdr", "a.nhdr", "encoding: raw\ndata file: part.raw\n", 1),
      detached("nhdr_of_several", "a.nhdr", "encoding: raw\ndata file: LIST\n" + names_of_parts(5),
               5),
      detached("nhdr_of_a_pattern", "a.nhdr", "encoding: raw\ndata file: part%d.raw 1 10 1\n", 10),
      detached("nhdr_with_lines_before", "a.nhdr",
               "encoding: raw\nline skip: 2\nbyte skip: 3\ndata file: ./part.raw\n", 1,
               "one\ntwo\nabc"),
      detached("nhdr_at_the_end", "a.nhdr", "encoding: raw\nbyteskip: -1\ndatafile: part.raw\n", 1,
               "whatever stands before"),
      detached("mhd", "a.mhd", "ElementDataFile = part.raw\n", 1),
      detached("mhd_behind_a_header", "a.mhd", "HeaderSize = -1\nElementDataFile = part.raw\n", 1,
               "twelve bytes"),
      detached("mhd_of_several", "a.mhd", "ElementDataFile = LIST\n" + names_of_parts(10), 10),
      detached("mhd_of_a_pattern", "a.mhd", "ElementDataFile = part%d.raw 1 5 1\n", 5),
      meta("mha", "", "i2"),
      left(meta("mha", "", "i2")),
      meta("mha_packed", "CompressedData = True\n", "f4"),
      meta("mha_big_endian", "BinaryDataByteOrderMSB = True\n", "i2"),
      meta("mha_text", "BinaryData = False\n", "text"),
  };
  return out;
}

class Forms : public testing::TestWithParam<Form> {};

TEST_P(Forms, VoxelsComeBackInTheirPlace) {
  const Beating object = oblique_object(GetParam().left_handed);
  const Folder folder;
  const ImageFile file = read_image_file(GetParam().write(folder, object));
  const Grid& grid = file.images.grid;
  ASSERT_EQ(grid.size, object.grid.size);
  ASSERT_EQ(file.images.phase_count(), object.frames);
  EXPECT_EQ(file.header.note, "");
  double worst = 0;
  double astray_mm = 0;
  for (int p = 0; p < object.frames; ++p) {
    ASSERT_EQ(file.images.phases[static_cast<std::size_t>(p)].size(), grid.count());
    for (int k = 0; k < grid.size[2]; ++k) {
      for (int j = 0; j < grid.size[1]; ++j) {
        for (int i = 0; i < grid.size[0]; ++i) {
          const double seen = file.images.phases[static_cast<std::size_t>(p)][grid.offset(i, j, k)];
          worst = std::max(worst, std::abs(seen - object.value(grid.mm(i, j, k), p)));
          astray_mm = std::max(astray_mm, (grid.mm(i, j, k) - object.grid.mm(i, j, k)).norm());
        }
      }
    }
  }
  EXPECT_LE(worst, kRounding);
  EXPECT_LE(astray_mm, kPlaceMm);
}

TEST_P(Forms, EveryFileThatHoldsAPartOfItIsNamed) {
  const Folder folder;
  const fs::path named = GetParam().write(folder, oblique_object());
  const std::vector<fs::path> files = files_of_image(named);
  EXPECT_EQ(files.front(), named);
  std::set<fs::path> written;
  for (const auto& entry : fs::directory_iterator(folder.path())) written.insert(entry.path());
  std::set<fs::path> told;
  for (const fs::path& file : files) told.insert(file.lexically_normal());
  EXPECT_EQ(told, written);
  EXPECT_EQ(told.size(), files.size());
}

INSTANTIATE_TEST_SUITE_P(All, Forms, testing::ValuesIn(forms()),
                         [](const auto& test) { return test.param.name; });

class ScalarTypes : public testing::TestWithParam<std::tuple<const char*, const char*, bool>> {};

TEST_P(ScalarTypes, KeepTheirWholeRange) {
  const auto [code, name, big_endian] = GetParam();
  const std::string type = code;
  std::vector<double> values{0, 1, 2, 3, 100, 5, 6, 127, 8, 9, 10, 11};
  if (type[0] != 'u') values[3] = -100;
  if (type[0] == 'u') values[3] = 200;
  if (type[1] != '1') values[4] = type[0] == 'u' ? 60000 : -30000;
  if (type[1] == '4' || type[1] == '8') values[5] = 16777216.0 * 100;
  if (type == "u8" || type == "i8" || type == "f8") values[6] = 1099511627776.0;
  const Folder folder;
  const std::string endian = std::string("endian: ") + (big_endian ? "big" : "little") + "\n";
  write(folder / "a.nrrd", std::string("NRRD0001\ntype: ") + name +
                               "\ndimension: 3\nsizes: 2 2 3\nspacings: 1 1 2\nencoding: raw\n" +
                               endian + "\n" + stored(values, type, big_endian));
  const ImageFile file = read_image_file(folder / "a.nrrd");
  const std::vector<double> seen(file.images.phases[0].begin(), file.images.phases[0].end());
  EXPECT_EQ(seen, values);
  EXPECT_NE(file.header.note.find("no orientation"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(
    Nrrd, ScalarTypes,
    testing::Values(std::tuple{"i1", "signed char", false}, std::tuple{"u1", "uchar", false},
                    std::tuple{"i2", "int16", true}, std::tuple{"u2", "unsigned short", false},
                    std::tuple{"i4", "int", true}, std::tuple{"u4", "uint32_t", false},
                    std::tuple{"i8", "long long", true}, std::tuple{"u8", "uint64", false},
                    std::tuple{"f4", "float", true}, std::tuple{"f8", "double", false}));

}  // namespace
}  // namespace beatlas::formats
