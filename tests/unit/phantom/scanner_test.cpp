#include <functional>
#include <set>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "runtime/base/error.h"
#include "runtime/base/json_text.h"
#include "tests/unit/phantom/scanner_images.h"

namespace beatlas::phantom {
namespace {

/// A very coarse one, for many images.
PhantomSpec quick() {
  PhantomSpec spec = test::coarse(6.0);
  spec.phases = 3;
  spec.scanner.slice_thickness_mm = 1.5;
  return spec;
}

/// Each fault alone: what switches it on, and the numbers that must not matter while it is off.
struct Fault {
  const char* name;
  std::function<void(ScannerSpec&)> on;
  std::function<void(ScannerSpec&)> other;
  std::function<void(ScannerSpec&)> reseed;  ///< empty: nothing is drawn
};

std::vector<Fault> faults() {
  return {
      {"noise", [](ScannerSpec& s) { s.snr_blood = 15; }, [](ScannerSpec& s) { s.noise_seed = 9; },
       [](ScannerSpec& s) { s.noise_seed = 9; }},
      {"bias", [](ScannerSpec& s) { s.bias_share = 0.4; }, [](ScannerSpec& s) { s.bias_seed = 9; },
       [](ScannerSpec& s) { s.bias_seed = 9; }},
      {"in-plane blur", [](ScannerSpec& s) { s.in_plane_sigma_mm = 0.8; }, [](ScannerSpec&) {}, {}},
      {"slice tails", [](ScannerSpec& s) { s.slice_sigma_mm = 0.8; }, [](ScannerSpec&) {}, {}},
      {"supersampling",
       [](ScannerSpec& s) { s.partial_volume = PartialVolume::Supersampled; },
       [](ScannerSpec&) {},
       {}},
      {"gating window",
       [](ScannerSpec& s) { s.gating_window_s = 0.06; },
       [](ScannerSpec& s) { s.gating_subphases = 9; },
       {}},
      {"shifts", [](ScannerSpec& s) { s.shift_sigma_mm = 2; },
       [](ScannerSpec& s) { s.shift_seed = 9, s.shift_limit_mm = 1; },
       [](ScannerSpec& s) { s.shift_seed = 9; }},
      {"jitter", [](ScannerSpec& s) { s.jitter_sigma_s = 0.02; },
       [](ScannerSpec& s) { s.trigger_seed = 9; }, [](ScannerSpec& s) { s.trigger_seed = 9; }},
      {"mis-trigger", [](ScannerSpec& s) { s.mistriggered_slices = 6; },
       [](ScannerSpec& s) { s.trigger_seed = 9, s.mistrigger_s = 0.1; },
       [](ScannerSpec& s) { s.trigger_seed = 9; }},
      {"flow void", [](ScannerSpec& s) { s.flow_void_share = 0.5; }, [](ScannerSpec&) {}, {}},
      {"arms",
       [](ScannerSpec& s) { s.arms = true; },
       [](ScannerSpec& s) { s.phase_encoding = std::string("j"); },
       {}},
  };
}

TEST(PhantomScanner, EachFaultShowsWhereItIsOnAndNowhereElse) {
  const PhantomSpec plain = quick();
  const auto image = test::images_of(plain);
  for (const Fault& fault : faults()) {
    PhantomSpec off = plain;
    fault.other(off.scanner);
    EXPECT_EQ(test::images_of(off), image) << fault.name << " off";
    PhantomSpec on = plain;
    fault.on(on.scanner);
    const auto faulty = test::images_of(on);
    EXPECT_NE(faulty, image) << fault.name;
    EXPECT_EQ(test::images_of(on), faulty) << fault.name << " again";
    if (!fault.reseed) continue;
    fault.reseed(on.scanner);
    EXPECT_NE(test::images_of(on), faulty) << fault.name << " of another seed";
  }
}

TEST(PhantomScanner, AFaultDoesNotChangeWhatAnotherDraws) {
  PhantomSpec spec = test::coarse();
  spec.scanner.shift_sigma_mm = 2;
  spec.scanner.jitter_sigma_s = 0.01;
  const auto before = acquisition(spec);
  spec.scanner.bias_share = 0.5;
  spec.scanner.snr_blood = 5;
  spec.scanner.noise_seed = 77;
  spec.scanner.mistriggered_slices = 2;
  const auto after = acquisition(spec);
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(before[k].shift_i_mm, after[k].shift_i_mm);
    if (!after[k].mistriggered) {
      EXPECT_EQ(before[k].offset_s, after[k].offset_s);
    }
  }
}

TEST(PhantomScanner, ImagesDoNotDependOnTheNumberOfThreads) {
  PhantomSpec spec = quick();
  for (const Fault& fault : faults()) fault.on(spec.scanner);
  std::set<std::vector<std::vector<float>>> seen;
  for (int threads : {1, 2, 3}) {
    set_thread_count(threads);
    seen.insert(test::images_of(spec));
  }
  set_thread_count(0);
  EXPECT_EQ(seen.size(), 1u);
}

TEST(PhantomScanner, SurvivesJson) {
  ScannerSpec spec;
  EXPECT_EQ(scanner_to_json(scanner_from_json(nlohmann::json::object(), "")),
            scanner_to_json(spec));
  for (const Fault& fault : faults()) fault.on(spec), fault.other(spec);
  spec.slice_thickness_mm = 6;
  spec.signals = "A";
  const nlohmann::json json = scanner_to_json(spec);
  const nlohmann::json plain = scanner_to_json(ScannerSpec{});
  for (const auto& [key, value] : json.items()) {
    EXPECT_NE(value, plain.at(key)) << key << " must be tried";
  }
  EXPECT_EQ(scanner_to_json(scanner_from_json(parse_json(json_text(json)), "")), json);
}

TEST(PhantomScanner, BadNumbersAreRefusedByTheirPath) {
  const nlohmann::json good = spec_to_json(test::coarse());
  const auto refused = [&](const std::string& key, const nlohmann::json& value) {
    nlohmann::json bad = good;
    bad["scanner"][key] = value;
    try {
      (void)spec_from_json(bad);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  for (const auto& [key, value] :
       std::vector<std::pair<std::string, nlohmann::json>>{{"bias_share", 0.95},
                                                           {"in_plane_sigma_mm", -1},
                                                           {"slice_sigma_mm", 11},
                                                           {"gating_window_s", 0.6},
                                                           {"gating_subphases", 0},
                                                           {"jitter_sigma_s", 10},
                                                           {"mistriggered_slices", 19},
                                                           {"mistrigger_s", 20},
                                                           {"shift_sigma_mm", 21},
                                                           {"shift_limit_mm", -1},
                                                           {"flow_void_share", 1.5},
                                                           {"slice_thickness_mm", 51},
                                                           {"noise_seed", -1},
                                                           {"bias_seed", 1.5},
                                                           {"snr_blood", 0.5},
                                                           {"arms", 1},
                                                           {"phase_encoding", "k"},
                                                           {"partial_volume", "some"},
                                                           {"signals", "C"},
                                                           {"gain", 2}}) {
    EXPECT_NE(refused(key, value).find("/scanner"), std::string::npos) << key;
    EXPECT_NE(refused(key, value).find(key), std::string::npos) << refused(key, value);
  }
  EXPECT_EQ(refused("snr_blood", nullptr), "");
  // In a spec that was not read, too.
  PhantomSpec spec = test::coarse();
  spec.scanner.bias_share = 2;
  EXPECT_THROW(check_spec(spec), Error);
}

TEST(PhantomScanner, AMatrixKeepsTheViewAndASpacingToo) {
  const Grid grid = preset("clinical").grid;
  const Vec3 middle = grid.mm(95.5, 95.5, 6.0);
  const Grid finer = on_matrix(grid, {384, 96, 26}, Vec3::Zero());
  EXPECT_TRUE(finer.spacing_mm().isApprox(Vec3(0.7, 2.8, 5.0), 1e-12));
  EXPECT_LT((finer.mm(191.5, 47.5, 12.5) - middle).norm(), 1e-9);
  const Grid coarser = on_matrix(grid, {0, 0, 0}, {2.8, 1.4, 5.0});
  EXPECT_EQ(coarser.size, (Index3{96, 192, 26}));
  EXPECT_LT((coarser.mm(47.5, 95.5, 12.5) - middle).norm(), 1e-9);
  const Grid both = on_matrix(grid, {50, 60, 7}, {2.0, 3.0, 4.0});
  EXPECT_EQ(both.size, (Index3{50, 60, 7}));
  EXPECT_TRUE(both.spacing_mm().isApprox(Vec3(2, 3, 4), 1e-12));
  EXPECT_LT((both.mm(24.5, 29.5, 3.0) - middle).norm(), 1e-9);
}

}  // namespace
}  // namespace beatlas::phantom
