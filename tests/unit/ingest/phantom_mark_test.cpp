#include "pipeline/core/phantom_mark.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/formats/dicom_writer.h"
#include "pipeline/formats/nifti.h"
#include "pipeline/ingest/ingest.h"
#include "tests/unit/study/temporary_folder.h"

namespace beatlas::ingest {
namespace {

namespace fs = std::filesystem;

const std::string kIdentity(64, 'c');

TEST(PhantomMark, HoldsAnIdentityAndNothingElse) {
  EXPECT_EQ(identity_of_mark(phantom_mark(kIdentity)), kIdentity);
  EXPECT_EQ(identity_of_mark(phantom_mark(kIdentity) + " "), kIdentity) << "padded, as DICOM does";
  EXPECT_EQ(phantom_mark(""), "");
  const std::string mark = phantom_mark(kIdentity);
  std::string shorter = mark;
  shorter.pop_back();
  std::string capital = mark;
  capital.back() = 'C';
  std::string no_digit = mark;
  no_digit.back() = 'z';
  const std::vector<std::string> others{"",      "DOE^JANE", kIdentity, mark + "DOE", " " + mark,
                                        shorter, capital,    no_digit,  "DOE " + mark};
  for (const std::string& text : others) {
    EXPECT_EQ(identity_of_mark(text), "") << text;
  }
}

/// A cine of 10 phases with a bright ball that grows, in a folder that goes away.
class Marked : public ::testing::Test {
 protected:
  Marked() {
    cine_.rr_interval_s = 0.8;
    cine_.images.grid.size = {16, 16, 6};
    cine_.images.grid.mm_from_index.linear() = Vec3(2.0, 2.0, 4.0).asDiagonal();
    for (int p = 0; p < 10; ++p) {
      std::vector<float>& phase = cine_.images.phases.emplace_back(16 * 16 * 6, 10.0F);
      for (std::size_t n = 0; n < phase.size(); n += 3 + static_cast<std::size_t>(p)) {
        phase[n] = 500.0F;
      }
      cine_.frame_times_s.push_back(0.08 * p);
    }
  }

  [[nodiscard]] std::string identity_of_import(const fs::path& source) const {
    StageContext context;
    return read_exam({source}, {}, context).phantom_identity;
  }
  void write_dicom(const std::string& comment) const {
    formats::DicomWriteOptions options;
    options.comment = comment;
    formats::write_dicom(folder_ / "dicom", cine_, options);
  }

  study::TemporaryFolder temporary_;
  fs::path folder_ = temporary_.path();
  Cine cine_;
};

TEST_F(Marked, DicomIsKnownByItsImageComments) {
  write_dicom(phantom_mark(kIdentity));
  EXPECT_EQ(identity_of_import(folder_ / "dicom"), kIdentity);
  // One image of another source among them, and the whole is of no phantom.
  const fs::path one = folder_ / "dicom" / "slice_003" / "phase_004.dcm";
  const fs::path kept = folder_ / "kept.dcm";
  write_dicom("somebody's comment");
  fs::rename(one, kept);
  write_dicom(phantom_mark(kIdentity));
  EXPECT_EQ(identity_of_import(folder_ / "dicom"), kIdentity);
  fs::copy_file(kept, one, fs::copy_options::overwrite_existing);
  EXPECT_EQ(identity_of_import(folder_ / "dicom"), "");
}

TEST_F(Marked, AnyOtherCommentIsLeft) {
  for (const std::string& comment :
       {std::string(), std::string("DOE^JANE 1950"), phantom_mark(kIdentity) + " of DOE^JANE"}) {
    write_dicom(comment);
    EXPECT_EQ(identity_of_import(folder_ / "dicom"), "") << comment;
  }
}

TEST_F(Marked, NiftiIsKnownByItsDescription) {
  const fs::path file = folder_ / "cine.nii.gz";
  const auto write = [&](const fs::path& to, const std::string& description) {
    formats::write_nifti(to, cine_.images, 0.08, formats::NiftiStorage::Int16, description);
  };
  write(file, phantom_mark(kIdentity));
  EXPECT_EQ(identity_of_import(file), kIdentity);
  write(file, "DOE^JANE");
  EXPECT_EQ(identity_of_import(file), "");
  EXPECT_ANY_THROW(write(file, std::string(80, 'x')));
}

TEST_F(Marked, AListOfFilesIsOfAPhantomIfAllAre) {
  const fs::path list = folder_ / "list";
  fs::create_directory(list);
  const auto write = [&](std::size_t p, const std::string& description) {
    formats::write_nifti(list / std::to_string(p).append(".nii"),
                         {cine_.images.grid, {cine_.images.phases[p]}}, 0.0,
                         formats::NiftiStorage::Int16, description);
  };
  for (std::size_t p = 0; p < 10; ++p) write(p, phantom_mark(kIdentity));
  StageContext context;
  IngestOptions options;
  options.rr_interval_s = 0.8;
  EXPECT_EQ(read_exam({list}, options, context).phantom_identity, kIdentity);
  write(4, phantom_mark(std::string(64, 'd')));
  EXPECT_EQ(read_exam({list}, options, context).phantom_identity, "");
}

}  // namespace
}  // namespace beatlas::ingest
