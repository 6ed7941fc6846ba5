#include "pipeline/build/fingerprint.h"

#include <fstream>
#include <set>

#include <gtest/gtest.h>

#include "tests/unit/study/temporary_folder.h"

namespace beatlas::build {
namespace {

Cine make_cine() {
  Cine cine;
  cine.images.grid = {{2, 2, 1}, Affine::Identity()};
  cine.images.phases = {{1, 2, 3, 4}, {5, 6, 7, 8}};
  cine.rr_interval_s = 0.8;
  cine.frame_times_s = {0, 0.4};
  return cine;
}

TEST(Fingerprint, TellsEveryPartOfAStackApart) {
  std::set<std::string> seen{stack_sha256(make_cine())};
  const auto expect_new = [&](const Cine& cine) {
    EXPECT_TRUE(seen.insert(stack_sha256(cine)).second);
  };
  Cine cine = make_cine();
  cine.images.phases[1][3] += 0.001F;
  expect_new(cine);
  cine = make_cine();
  std::swap(cine.images.phases[0], cine.images.phases[1]);
  expect_new(cine);
  cine = make_cine();
  cine.images.grid.mm_from_index.translation()[2] = 1e-12;
  expect_new(cine);
  cine = make_cine();
  cine.images.grid.size = {4, 1, 1};
  expect_new(cine);
  cine = make_cine();
  cine.rr_interval_s = 0.81;
  expect_new(cine);
  cine = make_cine();
  cine.frame_times_s[1] = 0.41;
  expect_new(cine);
}

TEST(Fingerprint, IsTheSameForTheSameStack) {
  EXPECT_EQ(stack_sha256(make_cine()), stack_sha256(make_cine()));
  EXPECT_EQ(stack_sha256(make_cine()).size(), 64U);
}

class SourceFingerprint : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& bytes) {
    std::filesystem::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name, std::ios::binary) << bytes;
  }
  /// A 3-D image whose voxels lie in a file beside it.
  void write_meta(const std::string& name, const std::string& voxels) {
    write(name + ".mhd",
          "ObjectType = Image\nNDims = 3\nDimSize = 1 1 1\nElementSpacing = 1 1 1\n"
          "ElementType = MET_UCHAR\nElementDataFile = " +
              std::filesystem::path(name).filename().string() + ".raw\n");
    write(name + ".raw", voxels);
  }
  void rename(const std::string& from, const std::string& to) {
    std::filesystem::rename(folder_.path() / from, folder_.path() / to);
  }
  [[nodiscard]] std::optional<std::string> of(const std::string& name) const {
    return source_sha256({folder_.path() / name});
  }
  study::TemporaryFolder folder_;
  /// Preamble, mark, the first element of every file and as many bytes as any image has.
  const std::string dicom_ =
      std::string(128, '\0').append("DICM").append("\2\0\0\0UL\4\0\0\0\0\0", 12).append(256, '\0');
};

TEST_F(SourceFingerprint, IsOfTheVoxelsThatAHeaderNames) {
  write_meta("one", "a");
  const auto before = of("one.mhd");
  ASSERT_TRUE(before);
  EXPECT_EQ(of("one.mhd"), before);
  write("one.raw", "b");
  EXPECT_NE(of("one.mhd"), before);
  EXPECT_TRUE(of("one.mhd"));
  std::filesystem::remove(folder_.path() / "one.raw");
  EXPECT_FALSE(of("one.mhd")) << "it cannot be read";
}

TEST_F(SourceFingerprint, OfImageFilesTheOrderCountsAndNothingBesideThem) {
  for (const char* name : {"cine/p1.nii", "cine/p2.nii"}) write(name, "no header");
  EXPECT_FALSE(of("cine"));
  for (const char* name : {"p1.nii", "p2.nii"}) {
    std::filesystem::remove(folder_.path() / "cine" / name);
  }
  write_meta("cine/p1", "a");
  write_meta("cine/p2", "b");
  const auto before = of("cine");
  ASSERT_TRUE(before);
  write("cine/notes.txt", "what the nurse said");
  write("cine/heart.beatlas", "what a build left");
  EXPECT_EQ(of("cine"), before);
  // The two phases swap their places.
  rename("cine/p1.raw", "cine/p3.raw");
  rename("cine/p2.raw", "cine/p1.raw");
  rename("cine/p3.raw", "cine/p2.raw");
  const auto swapped = of("cine");
  EXPECT_TRUE(swapped);
  EXPECT_NE(swapped, before);
  EXPECT_EQ(source_sha256({folder_.path() / "cine/p2.mhd", folder_.path() / "cine/p1.mhd"}),
            source_sha256({folder_.path() / "cine/p2.mhd", folder_.path() / "cine/p1.mhd"}));
  EXPECT_NE(source_sha256({folder_.path() / "cine/p2.mhd", folder_.path() / "cine/p1.mhd"}),
            source_sha256({folder_.path() / "cine/p1.mhd", folder_.path() / "cine/p2.mhd"}));
}

TEST_F(SourceFingerprint, OfDicomNeitherNamesNorOrderNorOtherFilesCount) {
  write("exam/a", dicom_ + "1");
  write("exam/b", dicom_ + "2");
  const auto before = of("exam");
  ASSERT_TRUE(before);
  rename("exam/a", "exam/c");
  write("exam/notes.txt", "what the nurse said");
  write("exam/empty", "");
  write("exam/out/labels.nii.gz", "what an export left");
  EXPECT_EQ(of("exam"), before);
  EXPECT_EQ(source_sha256({folder_.path() / "exam/b", folder_.path() / "exam/c"}), before);
  write("exam/d", dicom_ + "3");
  EXPECT_NE(of("exam"), before);
  EXPECT_FALSE(of("nowhere"));
}

}  // namespace
}  // namespace beatlas::build
