#include "pipeline/ingest/shown_path.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "tests/unit/formats/python_run.h"

namespace beatlas::ingest {
namespace {

TEST(ShownPath, PlainNamesAreShownAsTheyAre) {
  const IdentityWords none;
  for (const char* name :
       {"IM000123.dcm", "exam", "cine-sax_12", "series 4", "0000000042", "a.b"}) {
    EXPECT_FALSE(none.identify(name)) << name;
  }
  EXPECT_EQ(shown_path("/no/such/IM000123.dcm"), "/no/such/IM000123.dcm");
  EXPECT_EQ(shown_path("exam/x"), "exam/x");
  EXPECT_EQ(shown_path("../exam/"), "../exam/");
}

TEST(ShownPath, DatesIdsCaretsAndForeignLettersAreNoPlainNames) {
  const IdentityWords none;
  for (const char* name :
       {"20230517", "scan-12345.dcm", "1.2.840.10008.5", "DOE^JOHN", "M\xC3\xBCller", "0012345"}) {
    EXPECT_TRUE(none.identify(name)) << name;
  }
}

TEST(ShownPath, WordsOfTheTextsAreFoundHoweverTheyAreWritten) {
  IdentityWords words;
  words.add_text("Doe^John");
  words.add_text("P4711A");
  words.add_text("St. Mary cine series");
  for (const char* name : {"doe", "JOHN-1.dcm", "x_Doe_y", "johndoe", "MyJohn7", "doe2", "4711",
                           "p4711a", "IM04711", "mary"}) {
    EXPECT_TRUE(words.identify(name)) << name;
  }
  for (const char* name : {"dome", "jo", "471", "st", "cine_series", "47110"}) {
    EXPECT_EQ(words.identify(name), std::string(name) == "47110") << name;
  }
}

TEST(ShownPath, NumbersOfUidsCountAsWholeWordsOnly) {
  IdentityWords words;
  words.add_uid("1.3.6.777.123");
  EXPECT_TRUE(words.identify("777"));
  EXPECT_FALSE(words.identify("IM000123.dcm"));
  EXPECT_FALSE(words.identify("slice_0777"));
}

TEST(ShownPath, WordsOfTheTextsAreFoundInAnotherForm) {
  IdentityWords words;
  words.add_text("19800102");
  words.add_text("12-34-56");
  words.add_text("AB12CD");
  words.add_text("Mc Kay^Al");
  words.add_text("EF 34 GH");
  words.add_text("series 4");
  for (const char* name :
       {"born 1980-01-02", "02.01.1980", "01/02/1980", "80 01 02", "02.01.80", "12.34.56",
        "x 12 34 56 y", "123456", "AB 12 CD", "ab-12-cd", "ab12-cd", "McKay", "mc_kay", "EF34GH"}) {
    EXPECT_TRUE(words.identify(name)) << name;
  }
  for (const char* name : {"IM 1 2 3", "12 phases", "ab", "series 4", "cd 12", "12-34.dcm"}) {
    EXPECT_FALSE(words.identify(name)) << name;
  }
}

TEST(ShownPath, DatesWrittenApartAreNoPlainNames) {
  const IdentityWords none;
  for (const char* name : {"1980-01-02", "exam 02.01.1980", "x_2023_05_17_y"}) {
    EXPECT_TRUE(none.identify(name)) << name;
  }
  for (const char* name : {"1980-01", "12-34-567", "100-01-02", "1980-01-023"}) {
    EXPECT_FALSE(none.identify(name)) << name;
  }
}

TEST(ShownPath, ShortNamesAndIdsCountAsWholeWords) {
  IdentityWords words;
  words.add_identity("Wu^Li");
  words.add_identity("42");
  words.add_identity("01");
  IdentityWords merged;
  merged.merge(words);
  for (const char* name :
       {"Wu Li", "li-wu", "LiWu", "wuli", "patient 42", "0042", "01", "x_wu_y"}) {
    EXPECT_TRUE(merged.identify(name)) << name;
  }
  for (const char* name : {"lime", "IM42", "IM000042", "142", "series 1", "0"}) {
    EXPECT_FALSE(merged.identify(name)) << name;
  }
}

TEST(ShownPath, AnIdOfZerosAndADigitHidesNoImageNumber) {
  IdentityWords words;
  words.add_identity("0001");
  for (const char* name : {"IM000001", "all1", "slice 1"}) {
    EXPECT_FALSE(words.identify(name)) << name;
  }
  EXPECT_TRUE(words.identify("0001"));
}

TEST(ShownPath, ControlCharactersReachNoMessage) {
  EXPECT_EQ(shown_path("a\nb/IM\t0 \x1b[31m\x7f"), "a?b/IM?0 ?[31m?");
}

TEST(ShownPath, WhatItsUserTypedIsShownToHimAsHeTypedIt) {
  const beatlas::test::Folder folder;
  const std::filesystem::path exam = folder / "Doe^Jane 19800102";
  std::filesystem::create_directories(exam / "M\xC3\xBCller");
  std::ofstream(exam / "M\xC3\xBCller/12345678.dcm") << 'x';
  const std::filesystem::path file = exam / "M\xC3\xBCller/12345678.dcm";
  const std::string below = "[folder 1 of 1 by name]/[file 1 of 1 by name].dcm";
  EXPECT_EQ(shown_to({exam}, exam), exam.string());
  EXPECT_EQ(shown_to({exam}, file), exam.string() + "/" + below);
  EXPECT_EQ(shown_to({exam / ""}, file), exam.string() + "/" + below);
  EXPECT_EQ(shown_to({file}, file), file.string());
  EXPECT_EQ(shown_to({folder / "other", file}, file), file.string());
  EXPECT_EQ(shown_to({folder / "Doe^Jane 1980010"}, file), shown_path(file)) << "no part of it";
  EXPECT_EQ(shown_to({"a\nb"}, "a\nb"), "a?b");
  // Kept, neither what was typed nor where it lies.
  EXPECT_EQ(shown_below({exam}, file), below);
  EXPECT_EQ(shown_below({exam}, exam), "[folder 1 of 1 by name]");
  EXPECT_EQ(shown_below({file}, file), "[file 1 of 1 by name].dcm");
}

TEST(ShownPath, MergingKnowsWhatBothKnew) {
  IdentityWords a;
  IdentityWords b;
  a.add_text("Miller");
  b.add_text("Smith 9876");
  a.merge(b);
  EXPECT_TRUE(a.identify("miller"));
  EXPECT_TRUE(a.identify("smith"));
  EXPECT_TRUE(a.identify("img9876"));
}

TEST(ShownPath, MaskedFilesAndFoldersCanBeFoundByTheirNumber) {
  const beatlas::test::Folder folder;
  for (const char* name : {"A", "Doe_John", "Z"}) {
    std::filesystem::create_directory(folder / name);
  }
  for (const char* name : {"a.dcm", "doe.DCM", "john", "z.dcm"}) {
    std::ofstream(folder / "Doe_John" / name) << 'x';
  }
  std::filesystem::create_directory(folder / "Doe_John/m");  // a folder does not count as a file
  IdentityWords words;
  words.add_text("DOE^JOHN");
  const std::string start = shown_path(folder.path(), words);
  EXPECT_EQ(shown_path(folder / "Doe_John/doe.DCM", words),
            start + "/[folder 2 of 3 by name]/[file 2 of 4 by name].dcm");
  EXPECT_EQ(shown_path(folder / "Doe_John/john", words),
            start + "/[folder 2 of 3 by name]/[file 3 of 4 by name]");
  EXPECT_EQ(shown_path(folder / "Doe_John/m", words), start + "/[folder 2 of 3 by name]/m");
  EXPECT_EQ(shown_path(folder / "Doe_John/doe_absent.dcm", words),
            start + "/[folder 2 of 3 by name]/[name not shown].dcm");
  EXPECT_EQ(shown_path(folder / "Doe_John/doe.surname", words),
            start + "/[folder 2 of 3 by name]/[name not shown]")
      << "an extension that is no file format may be a name";
}

}  // namespace
}  // namespace beatlas::ingest
