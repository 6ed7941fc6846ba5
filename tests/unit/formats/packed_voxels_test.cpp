// Small packed files whose voxels would take much memory. Their zeros are really there: no check of
// the format would find anything wrong.
#include <fstream>

#include <gtest/gtest.h>

#include "pipeline/formats/image_file.h"
#include "pipeline/formats/nifti.h"
#include "runtime/base/error.h"
#include "tests/unit/formats/image_bytes.h"
#include "tests/unit/formats/python_run.h"

namespace beatlas::formats {
namespace {

using namespace beatlas::test;

Grid grid_of(int edge, int slices) {
  Grid grid = oblique_object().grid;
  grid.size = {edge, edge, slices};
  return grid;
}

struct Form {
  const char* name;
  std::string (*bytes)(const Grid& grid, const std::string& voxels);
};

const Form kForms[] = {
    {"gzip.nii.gz",
     [](const Grid& grid, const std::string& voxels) {
       return gzip(nifti_header(grid, 1, {.type = "u1"}) + voxels);
     }},
    {"gzip.nrrd",
     [](const Grid& grid, const std::string& voxels) {
       return nrrd_header(grid, 1, false, "left-posterior-superior", "uchar") +
              "encoding: gzip\n\n" + gzip(voxels);
     }},
    {"bzip2.nrrd",
     [](const Grid& grid, const std::string& voxels) {
       return nrrd_header(grid, 1, false, "left-posterior-superior", "uchar") +
              "encoding: bzip2\n\n" + bzip2(voxels);
     }},
    {"zlib.mha",
     [](const Grid& grid, const std::string& voxels) {
       return meta_header(grid, 1, "MET_UCHAR") + "CompressedData = True\n" +
              "ElementDataFile = LOCAL\n" + zlib(voxels);
     }},
};

std::string zeros(const Grid& grid) { return std::string(grid.count(), '\0'); }

/// The reason of a refusal; empty if the file was read.
template <class Read>
std::string refusal(const Form& form, const Grid& grid, Read&& read) {
  const Folder folder;
  std::ofstream(folder / form.name, std::ios::binary) << form.bytes(grid, zeros(grid));
  try {
    read(folder / form.name);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return {};
}

void as_image(const std::filesystem::path& file) { (void)read_image_file(file); }
void as_labels(const std::filesystem::path& file) { (void)read_nifti_labels(file); }

TEST(PackedVoxels, AreBelievedToAStatedRatioOfTheirBytes) {
  for (const Form& form : kForms) {
    EXPECT_EQ(refusal(form, grid_of(512, 60), as_image), "") << form.name;  // 63 MB of floats
    const std::string message = refusal(form, grid_of(512, 120), as_image);
    EXPECT_NE(message.find("voxels that take 125.9 MB, but its 0.1 MB of packed data are believed "
                           "to hold at most"),
              std::string::npos)
        << form.name << ": " << message;
    EXPECT_NE(message.find("save the file unpacked"), std::string::npos) << message;
  }
}

TEST(PackedVoxels, OfLabelsTakeAByteEach) {
  EXPECT_EQ(refusal(kForms[0], grid_of(512, 240), as_labels), "");
  EXPECT_NE(refusal(kForms[0], grid_of(512, 480), as_labels), "");
}

TEST(PackedVoxels, PassedOverCountAsWell) {
  const Grid grid = grid_of(8, 3);
  const Form skipping{"bzip2.nrrd", [](const Grid& of, const std::string& voxels) {
                        return nrrd_header(of, 1, false, "left-posterior-superior", "uchar") +
                               "encoding: bzip2\nbyte skip: 90000000\n\n" +
                               bzip2(std::string(90'000'000, '\0') + voxels);
                      }};
  EXPECT_NE(refusal(skipping, grid, as_image).find("are believed to hold at most"),
            std::string::npos);
}

}  // namespace
}  // namespace beatlas::formats
