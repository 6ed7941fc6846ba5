// Specs of phantoms that users write, and the truth of one that a package is compared with.
#include "pipeline/phantom/spec.h"
#include "pipeline/phantom/truth.h"
#include "runtime/base/json_text.h"
#include "tests/fuzz/fuzz_target.h"

namespace beatlas::fuzz {
std::vector<std::string> seeds() {
  std::vector<std::string> out;
  nlohmann::json spec;
  for (const std::string& name : phantom::preset_names()) {
    spec = phantom::spec_to_json(phantom::preset(name));
    out.push_back(json_text(spec));
  }
  out.push_back(R"({"grid": )" + json_text(spec["grid"]) + "}");
  out.push_back(R"({"format": "beatlas-phantom-truth", "version": 1, "spec": )" + out.front() +
                "}");
  return out;
}
std::vector<std::string> tokens() { return json_tokens({"1e300", "2147483648"}); }
}  // namespace beatlas::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace beatlas;
  const nlohmann::json json = parse_json(fuzz::text(data, size));
  if (json.is_discarded()) return 0;
  fuzz::only_errors([&] {
    const phantom::PhantomSpec spec = phantom::spec_from_json(json);
    fuzz::require(spec.imaging_grid().mm_from_index.matrix().allFinite());
    const nlohmann::json again = phantom::spec_to_json(spec);
    fuzz::require(phantom::spec_to_json(phantom::spec_from_json(again)) == again);
  });
  fuzz::only_errors([&] { (void)phantom::phantom_from_truth(json); });
  return 0;
}
