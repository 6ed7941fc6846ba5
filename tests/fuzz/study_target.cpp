// study.json and the JSON values of the stages' files.
#include "pipeline/study/files.h"
#include "pipeline/study/json_values.h"
#include "pipeline/study/state.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  return {R"({"study_format": 2, "recipe": {"mesh": {}}, "seeds": null, "writing": "field",
              "former": ["field/heart.vdb"], "stages": {
              "import": {"version": "0.1.0", "options": {}, "inputs": {"source": "ab"},
                         "outputs": {"exam/exam.json": "cd"}},
              "segment": {"version": "0.1.0", "options": {}, "inputs": {"exam/exam.json": "cd"},
                          "outputs": {"segment/labels.nii.gz": "ef"}}}})",
          R"({"size": [4, 5, 6], "mm_from_index": [1,0,0,1, 0,2,0,1, 0,0,3,1, 0,0,0,1]})",
          R"([1, 2.5, 3])", R"(["a", "b"])"};
}
std::vector<std::string> tokens() { return json_tokens({"..", "/", "../../x"}); }
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  static const fuzz::MemoryFolder folder;
  const auto file = folder.write("study.json", fuzz::text(data, size));
  fuzz::only_errors([&] {
    const auto study = study::Study::open(folder.path());
    for (const auto stage : study::kAllStages) {
      fuzz::only_errors([&] { (void)study::edited_outputs(study, stage); });
      fuzz::only_errors([&] { (void)study::edited_for_the_eye(study, stage); });
      fuzz::only_errors([&] {
        (void)study::state_of(study, stage, {.version = "0.1.0", .sources_sha256 = "0"});
      });
    }
  });
  nlohmann::json json;
  fuzz::only_errors([&] { json = study::read_json(file); });
  fuzz::only_errors([&] { (void)study::grid_from_json(json, "/a"); });
  fuzz::only_errors([&] { (void)study::numbers_from_json(json, "/a"); });
  fuzz::only_errors([&] { (void)study::strings_from_json(json, "/a"); });
  fuzz::only_errors([&] { (void)study::index_from_json(json, "/a"); });
  fuzz::only_errors([&] { (void)study::affine_from_json(json, "/a"); });
  return 0;
}
