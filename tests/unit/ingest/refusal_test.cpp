#include <fstream>

#include <gtest/gtest.h>

#include "tests/unit/ingest/made_exam.h"

namespace beatlas::ingest {
namespace {

using test::MadeExam;

struct Case {
  const char* variant;
  const char* reason;
};

class Refusals : public testing::TestWithParam<Case> {};

TEST_P(Refusals, NameThePlaceAndTheReason) {
  const MadeExam made(GetParam().variant);
  const std::string message = made.refusal();
  EXPECT_NE(message.find(GetParam().reason), std::string::npos) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << "one sentence";
}

INSTANTIATE_TEST_SUITE_P(
    Dicom, Refusals,
    testing::Values(Case{"empty", "the folder is empty"}, Case{"nothing", "is a DICOM image"},
                    Case{"one_phase", "only one phase"},
                    Case{"two_slices", "at most 2 parallel slices"},
                    Case{"zero", "phase 1 of 10 shows nothing"},
                    Case{"one_zero_phase", "phase 5 of 10 shows nothing"},
                    Case{"colour", "in colour"}, Case{"no_position", "names its position"},
                    Case{"wild_cosines", "direction cosines are not of unit length"},
                    Case{"mixed_size", "10 x 8 pixels"},
                    Case{"truncated_pixels", "the_bad_one: the file is truncated"},
                    Case{"truncated_header", "the_bad_one: the file is truncated"},
                    Case{"jpeg_lossless_cut", "the_bad_one: the file is truncated"},
                    Case{"spacing_zero", "the_bad_one: its pixel spacing is zero, negative"},
                    Case{"spacing_negative", "the_bad_one: its pixel spacing is zero, negative"},
                    Case{"spacing_nan", "the_bad_one: its pixel spacing is zero, negative"},
                    Case{"spacing_one_value", "the_bad_one: its pixel spacing is zero, negative"},
                    Case{"position_nan", "the_bad_one: its position is no number"},
                    Case{"float_nan",
                         "it holds pixels that are no number (NaN or infinite); "
                         "export it again (1 more images are as bad)"},
                    Case{"damaged_by_name",
                         "/[folder 5 of 5 by name]/[file 2 of 2 by name].dcm: "
                         "the file is truncated or damaged"},
                    Case{"damaged_several", "(2 more are like it)"},
                    Case{"two_patients", "2 exams of different patients"},
                    Case{"hole", "lies between slices of series 3, 4, where none was found"}),
    [](const auto& test) { return std::string(test.param.variant); });

std::string refusal(const std::vector<std::filesystem::path>& sources,
                    const IngestOptions& options = {}) {
  StageContext context;
  try {
    (void)read_exam(sources, options, context);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    return error.what();
  }
  return "was read";
}

TEST(Refusal, SourcesThatCannotBeRead) {
  const beatlas::test::Folder folder;
  const auto touch = [&](const std::string& name) {
    std::ofstream(folder / name) << "some text";
    return folder / name;
  };
  EXPECT_NE(refusal({folder / "absent"}).find("no such file or folder"), std::string::npos);
  EXPECT_NE(refusal({}).find("no source"), std::string::npos);
  EXPECT_NE(refusal({touch("a.txt")}).find("a.txt: it is no image"), std::string::npos);
  EXPECT_NE(refusal({touch("a.nii")}).find("a.nii: it is no NIfTI"), std::string::npos);
  EXPECT_NE(refusal({touch("a.mha")}).find("no MetaImage"), std::string::npos);
  EXPECT_NE(refusal({touch("a.nrrd")}).find("no NRRD"), std::string::npos);
  EXPECT_NE(refusal({touch("a.zip")}).find("unpack"), std::string::npos);
  EXPECT_NE(refusal({folder / "a.nii", folder / "a.txt"}).find("not both"), std::string::npos);
}

TEST(Refusal, OptionsOutOfRange) {
  EXPECT_NE(refusal({"x"}, {.rr_interval_s = 30}).find("0.2 to 3 s"), std::string::npos);
  EXPECT_NE(refusal({"x"}, {.phases = 1}).find("2 to 200"), std::string::npos);
}

}  // namespace
}  // namespace beatlas::ingest
