// A folder of cases: read, searched, listed, and touched as the command line alone would have it.

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "runtime/app/case_files.h"
#include "runtime/app/text.h"
#include "runtime/app/window.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "runtime/base/sha256.h"
#include "tests/unit/runtime_app/played_ellipsoid.h"

namespace beatlas::app {
namespace {

using namespace test;
namespace fs = std::filesystem;

const fs::path kSamples = BEATLAS_SOURCE_DIR "/samples/cases";

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string sha256_of(const fs::path& file) {
  const std::string bytes = bytes_of(file);
  return sha256_hex(std::as_bytes(std::span(bytes)));
}

nlohmann::json plain_case() {
  return {{"version", 1}, {"title", "A heart"}, {"felt", nlohmann::json::array()}};
}

/// Written beside the packages of the ellipsoid.
fs::path case_file(const nlohmann::json& document, const std::string& name = "c.case.json") {
  std::ofstream(folder() / name) << document;
  return folder() / name;
}

std::string refusal(const nlohmann::json& change) {
  nlohmann::json document = plain_case();
  document.merge_patch(change);
  const fs::path file = case_file(document);
  try {
    (void)read_case(file);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidInput);
    const std::string said = error.what();
    EXPECT_TRUE(said.starts_with(file.string() + ": /")) << said;
    return said;
  }
  return "";
}

/// A folder of its own for cases, emptied.
fs::path empty_folder() {
  const fs::path out = folder() / "cases";
  fs::remove_all(out);
  fs::create_directories(out);
  return out;
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Cases, SamplesAreReadAndWrittenAsTheyWere) {
  const Cases cases = read_cases(kSamples);
  EXPECT_TRUE(cases.troubles.empty());
  ASSERT_EQ(cases.read.size(), 3U);
  for (const Case& sample : cases.read) {
    EXPECT_EQ(case_to_json(sample), read_json_file(sample.file.string())) << sample.file;
    EXPECT_EQ(std::count(sample.tags.begin(), sample.tags.end(), "made-up"), 1) << sample.file;
    EXPECT_EQ(atlas_state(sample), AtlasState::None);
  }
  const nlohmann::json whole = {{"version", 1},
                                {"title", "Everything that can be told"},
                                {"diagnosis", "None"},
                                {"tags", {"one", "two"}},
                                {"atlas", "a/b.beatlas"},
                                {"atlas_sha256", std::string(64, 'a')},
                                {"parameters", "p.json"},
                                {"heart_rate_per_min", 30},
                                {"felt",
                                 {{{"segment", "apex"},
                                   {"when", "systole"},
                                   {"words", "hard"},
                                   {"force_n", 0},
                                   {"depth_mm", 15}}}}};
  const Case read = read_case(case_file(whole));
  EXPECT_EQ(case_to_json(read), whole);
  EXPECT_EQ(read.felt.at(0).segment, 17);
  EXPECT_EQ(read.atlas_path(), folder() / "a/b.beatlas");
  EXPECT_EQ(read.parameters_path(), folder() / "p.json");
}

TEST(Cases, WhatCannotBeIsRefusedByItsPlace) {
  EXPECT_EQ(refusal(nlohmann::json::object()), "");
  const auto refused = [](const nlohmann::json& change, const std::string& words) {
    const std::string said = refusal(change);
    EXPECT_TRUE(has(said, words)) << "'" << said << "' lacks '" << words << "'";
  };
  refused({{"version", nullptr}}, "/version is missing");
  refused({{"version", 2}}, "/version");
  refused({{"title", nullptr}}, "/title is missing");
  refused({{"title", 3}}, "/title must be a string");
  refused({{"title", ""}}, "/title must be words in one line");
  refused({{"diagnosis", "two\nlines"}}, "/diagnosis must be words in one line");
  refused({{"felt", nullptr}}, "/felt is missing");
  refused({{"felt", "soft"}}, "/felt must be a list");
  refused({{"patient_name", "none"}}, "/patient_name is not a known key");
  refused({{"tags", "made-up"}}, "/tags must be a list");
  refused({{"tags", {"a", 1}}}, "/tags/1 must be a string");
  refused({{"tags", {"a", "b", "\x1b[2J"}}}, "/tags/2 must be words in one line");
  refused({{"atlas", "heart.nii.gz"}}, "/atlas must be the name of a .beatlas file");
  refused({{"atlas", "/data/heart.beatlas"}}, "/atlas must start from the case's own folder");
  refused({{"atlas", "h.beatlas"}, {"atlas_sha256", std::string(64, 'A')}}, "/atlas_sha256 must");
  refused({{"atlas", "h.beatlas"}, {"atlas_sha256", std::string(63, 'a')}}, "/atlas_sha256 must");
  refused({{"atlas", "h.beatlas"}, {"atlas_sha256", ""}}, "/atlas_sha256 must");
  refused({{"atlas_sha256", std::string(64, 'a')}}, "name it by /atlas");
  refused({{"preset", "fever"}}, "/preset must be healthy");
  refused({{"parameters", "/p.json"}}, "/parameters must start from the case's own folder");
  refused({{"preset", "healthy"}, {"parameters", "p.json"}}, "/preset and /parameters both");
  refused({{"heart_rate_per_min", 29}}, "/heart_rate_per_min must be a number from 30 to 220");
  refused({{"heart_rate_per_min", 221}}, "/heart_rate_per_min must be a number from 30 to 220");
}

TEST(Cases, WhatWasFeltIsRefusedByItsPlace) {
  const auto refused = [](const nlohmann::json& entry, const std::string& words) {
    const nlohmann::json sound = {{"when", "systole"}, {"words", "hard"}};
    const std::string said = refusal({{"felt", {sound, entry}}});
    EXPECT_TRUE(has(said, "/felt/1" + words)) << "'" << said << "' lacks '" << words << "'";
  };
  refused(7, " must be a JSON object");
  refused({{"words", "hard"}}, "/when is missing");
  refused({{"when", "systole"}}, "/words is missing");
  refused({{"when", "always"}, {"words", "hard"}}, "/when must be diastole, systole or throughout");
  const auto with = [](const char* key, const nlohmann::json& value) -> nlohmann::json {
    return {{"when", "systole"}, {"words", "hard"}, {key, value}};
  };
  EXPECT_EQ(refusal({{"felt", {with("segment", "mid_anterior")}}}), "");
  refused(with("segment", "left"), "/segment is none of basal_anterior");
  refused(with("segment", 3), "/segment must be a string");
  refused(with("force_n", 50.1), "/force_n must be a number from 0 to 50");
  refused(with("depth_mm", -1), "/depth_mm must be a number from 0 to 15");
  refused(with("finger", "left"), "/finger is not a known key");
}

TEST(Cases, OfAFolderAreListedByNameAndABrokenOneIsTold) {
  const fs::path cases = empty_folder();
  const auto write = [&](const std::string& name, const std::string& title) {
    nlohmann::json document = plain_case();
    document["title"] = title;
    std::ofstream(cases / name) << document;
  };
  write("b.case.json", "The second");
  write("e.case.json", "The third");
  write("a.case.json", "The first");
  write("notes.json", "No case by its name");
  std::ofstream(cases / "c.case.json") << "{";
  fs::create_directory(cases / "d.case.json");
  const Cases read = read_cases(cases);
  ASSERT_EQ(read.read.size(), 3U);
  EXPECT_EQ(read.read[0].title, "The first");
  EXPECT_EQ(read.read[1].title, "The second");
  EXPECT_EQ(read.read[2].title, "The third");
  EXPECT_EQ(read.troubles.size(), 2U);

  const Result listed = run({"cases", cases.string()});
  EXPECT_EQ(listed.code, 3);
  EXPECT_EQ(listed.out,
            "a.case.json: The first; no atlas; 0 felt\nb.case.json: The second; no atlas; 0 felt\n"
            "e.case.json: The third; no atlas; 0 felt\n");
  EXPECT_EQ(std::count(listed.err.begin(), listed.err.end(), '\n'), 2);
  EXPECT_TRUE(listed.err.starts_with("beatlas-play: " + (cases / "c.case.json").string() +
                                     " is not valid JSON\n"))
      << listed.err;
  // What is broken is told even where what is sound does not match.
  EXPECT_EQ(run({"cases", cases.string(), "third"}).code, 3);

  const Result none = run({"cases", (cases / "none").string()});
  EXPECT_EQ(none.code, 3);
  EXPECT_TRUE(has(none.err, "is no folder that can be read")) << none.err;
  const Result empty = run({"cases", empty_folder().string()});
  EXPECT_EQ(empty.code, 0);
  EXPECT_TRUE(has(empty.out, "holds no case")) << empty.out;
}

TEST(Cases, HaveEveryWordThatIsLookedFor) {
  Case found;
  found.title = "An old scar";
  found.diagnosis = "Infarction";
  found.tags = {"Made-Up", "teaching"};
  found.preset = "low_pressure";
  found.felt = {{.segment = 7,
                 .when = FeltWhen::Systole,
                 .words = "stays slack",
                 .force_n = {},
                 .depth_mm = {}}};
  for (const char* word :
       {"OLD", "infarct", "made-up", "teach", "pressure", "mid_anterior", "slack"}) {
    EXPECT_TRUE(matches(found, {word})) << word;
  }
  EXPECT_TRUE(matches(found, {}));
  EXPECT_TRUE(matches(found, {"scar", "SLACK", "anterior"}));
  EXPECT_FALSE(matches(found, {"scar", "hard"}));
  EXPECT_FALSE(matches(found, {"scarInfarction"})) << "a word lies in one of them, not across two";
  EXPECT_FALSE(matches(found, {"systole"}));

  const Result one = run({"cases", kSamples.string(), "SLACK", "made-up", "infarct"});
  EXPECT_EQ(one.code, 0) << one.err;
  EXPECT_TRUE(one.out.starts_with("anterior_infarct.case.json: ")) << one.out;
  for (const Felt& felt : read_case(kSamples / "anterior_infarct.case.json").felt) {
    EXPECT_TRUE(has(one.out, felt.words)) << one.out;
  }
  EXPECT_TRUE(has(one.out, "mid_anterior, diastole: ")) << one.out;
  EXPECT_TRUE(has(one.out, "(0.7 N at 8 mm)")) << one.out;
  const Result all = run({"cases", kSamples.string()});
  EXPECT_EQ(std::count(all.out.begin(), all.out.end(), '\n'), 3) << all.out;
  const Result none = run({"cases", kSamples.string(), "slack", "tumour"});
  EXPECT_EQ(none.code, 0);
  EXPECT_TRUE(none.out.starts_with("none of 3 cases in ")) << none.out;
  EXPECT_TRUE(has(none.out, "has slack, tumour")) << none.out;
  EXPECT_EQ(parse_json(run({"cases", kSamples.string(), "tumour", "--json"}).out),
            nlohmann::json({{"cases", nlohmann::json::array()}}));
  // A word that is also a command's name is a word here.
  EXPECT_EQ(run({"cases", kSamples.string(), "probe"}).code, 0);
}

TEST(Cases, TellWhetherTheirAtlasIsThereAndTheSame) {
  const fs::path cases = empty_folder();
  const auto state = [&](const nlohmann::json& change) {
    nlohmann::json document = plain_case();
    document.merge_patch(change);
    std::ofstream(cases / "x.case.json") << document;
    const Result listed = run({"cases", cases.string(), "--json"});
    EXPECT_EQ(listed.code, 0) << listed.err;
    return parse_json(listed.out)["cases"][0]["atlas_state"].get<std::string>();
  };
  const std::string right = sha256_of(package());
  EXPECT_EQ(state(nlohmann::json::object()), "none");
  EXPECT_EQ(state({{"atlas", "heart.beatlas"}}), "missing");
  EXPECT_EQ(state({{"atlas", "../heart.beatlas"}}), "there");
  EXPECT_EQ(state({{"atlas", "../heart.beatlas"}, {"atlas_sha256", right}}), "same");
  EXPECT_EQ(state({{"atlas", "../stiff.beatlas"}, {"atlas_sha256", right}}), "other");
  EXPECT_TRUE(has(run({"cases", cases.string()}).out, "of another SHA-256"));
}

/// Of the ellipsoid with a cavity, under little pressure, at 90 beats.
nlohmann::json cavity_case() {
  nlohmann::json document = plain_case();
  document.merge_patch({{"atlas", "cavity.beatlas"},
                        {"atlas_sha256", sha256_of(folder() / "cavity.beatlas")},
                        {"preset", "low_pressure"},
                        {"heart_rate_per_min", 90}});
  return document;
}

TEST(Cases, AreFeltAsTheirPresetByADeviceAPressAndFingers) {
  const std::string cavity = (folder() / "cavity.beatlas").string();
  const std::string file = case_file(cavity_case()).string();
  // What each way of touching writes, of a call that begins with these words.
  const auto felt = [](std::vector<std::string> words, const std::string& how) {
    const fs::path out = folder() / "felt";
    fs::remove_all(out);
    fs::create_directories(out);
    if (how == "press") {
      words.insert(words.end(), {"--headless", "--press", out.string()});
    } else {
      words.insert(words.end(), {"--headless", "--fast", "--seconds", "2", "--depth-mm", "5",
                                 "--trace", (out / "trace.csv").string()});
      if (how == "fingers") {
        words.insert(words.end(), {"--fingers", BEATLAS_SOURCE_DIR "/samples/fingers.json"});
      }
    }
    const Result result = run(words);
    EXPECT_EQ(result.code, 0) << result.err;
    const char* name = how == "press"     ? "press.json"
                       : how == "fingers" ? "trace_2.csv"
                                          : "trace.csv";
    const std::string written = bytes_of(out / name);
    EXPECT_FALSE(written.empty());
    return written;
  };
  for (const std::string how : {"device", "press", "fingers"}) {
    const std::string by_case = felt({"--case", file}, how);
    const std::vector<std::string> patch =
        how == "press" ? std::vector<std::string>{cavity}
                       : std::vector<std::string>{cavity, "--model", "patch"};
    const auto told = [&](std::vector<std::string> more) {
      more.insert(more.begin(), patch.begin(), patch.end());
      return felt(more, how);
    };
    EXPECT_EQ(by_case, told({"--preset", "low_pressure", "--heart-rate", "90"})) << how;
    EXPECT_NE(by_case, told({"--preset", "healthy", "--heart-rate", "90"})) << how;
    EXPECT_NE(by_case, told({"--preset", "low_pressure", "--heart-rate", "70"})) << how;
  }
}

TEST(Cases, TakeTheirParametersFromTheirFolderAndAnotherPackage) {
  std::ofstream(folder() / "low.json")
      << nlohmann::json{{"circulation", {{"left_atrial_mmhg", 3}}}};
  nlohmann::json document = plain_case();
  document["parameters"] = "low.json";
  const std::string file = case_file(document).string();
  const std::string trace = (folder() / "t.csv").string();
  const auto felt = [&](std::vector<std::string> words) {
    words.insert(words.end(),
                 {"--headless", "--fast", "--seconds", "1", "--depth-mm", "5", "--trace", trace});
    const Result result = run(words);
    EXPECT_EQ(result.code, 0) << result.err;
    return bytes_of(trace);
  };
  const std::string cavity = (folder() / "cavity.beatlas").string();
  const std::string by_case = felt({cavity, "--case", file});
  EXPECT_EQ(by_case,
            felt({cavity, "--model", "patch", "--parameters", (folder() / "low.json").string()}));
  EXPECT_NE(by_case, felt({cavity, "--model", "patch"}));

  // A package that is named stands for the case's own, whatever that is.
  document["atlas"] = "none.beatlas";
  EXPECT_EQ(by_case, felt({cavity, "--case", case_file(document).string()}));
}

TEST(Cases, AreRefusedWithASentence) {
  const auto refused = [](std::vector<std::string> more, int code, const std::string& words,
                          const nlohmann::json& document = cavity_case()) {
    std::vector<std::string> all{"--case", case_file(document).string(), "--seconds", "0.1",
                                 "--fast"};
    all.insert(all.end(), more.begin(), more.end());
    const Result result = run(all);
    EXPECT_EQ(result.code, code) << result.err;
    EXPECT_TRUE(result.out.empty());
    EXPECT_TRUE(has(result.err, words)) << result.err;
    EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << result.err;
  };
  refused({}, 2, "this build has no viewer; use --headless");
  // The word of the default is a word as well.
  refused({"--headless", "--model", "proxy"}, 2, "leave --model out");
  refused({"--headless", "--preset", "healthy"}, 2, "leave --preset out");
  refused({"--headless", "--parameters", "p.json"}, 2, "leave --parameters out");
  refused({"--headless", "--heart-rate", "60"}, 2, "leave --heart-rate out");
  refused({"--headless", "--published"}, 2, "leave --published out");
  refused({"--headless", "--inside", "lv_blood"}, 2, "leave --inside out");
  refused({"--headless", "--exercise", "e.json", "--session", "s"}, 2, "leave --exercise out");
  refused({"--headless"}, 2, "names no atlas; name a PACKAGE beside --case", plain_case());

  nlohmann::json document = cavity_case();
  document["atlas"] = "stiff.beatlas";
  refused({"--headless"}, 3, "/atlas_sha256 is not that of", document);
  document["atlas"] = "none.beatlas";
  refused({"--headless"}, 3, "none.beatlas cannot be read", document);
  document = plain_case();
  document["parameters"] = "none.json";
  refused({package(), "--headless"}, 3, "none.json cannot be read", document);
  document["name"] = "none";
  refused({package(), "--headless"}, 3, "/name is not a known key", document);
  const Result missing = run({"--case", (folder() / "none.case.json").string(), "--headless"});
  EXPECT_EQ(missing.code, 3);
  EXPECT_TRUE(has(missing.err, "none.case.json cannot be read")) << missing.err;
}

TEST(Cases, AreSearchedWithoutAPictureAndTouchedInOne) {
  constexpr std::array<const char*, 3> kSearch{"beatlas-play", "cases", "folder"};
  constexpr std::array<const char*, 3> kTouch{"beatlas-play", "--case", "c.case.json"};
  constexpr std::array<const char*, 2> kWindow{"beatlas-play", "heart.beatlas"};
  EXPECT_FALSE(wants_picture(kSearch.size(), kSearch.data()));
  EXPECT_TRUE(wants_picture(kTouch.size(), kTouch.data()));
  EXPECT_TRUE(wants_picture(kWindow.size(), kWindow.data()));
}

}  // namespace
}  // namespace beatlas::app
