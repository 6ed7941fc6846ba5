#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <set>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "pipeline/prior/orientations.h"
#include "pipeline/prior/prior.h"
#include "runtime/base/error.h"
#include "tests/unit/prior/made_models.h"

namespace beatlas::prior {
namespace {

/// Percentile of sorted values, linear between two.
double percentile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double place = share * static_cast<double>(values.size() - 1);
  const auto at = static_cast<std::size_t>(place);
  const double next = values[std::min(at + 1, values.size() - 1)];
  return values[at] + (place - static_cast<double>(at)) * (next - values[at]);
}

/// Brightness [phase][voxel] of an exam whose pixels are the network's own.
std::vector<std::vector<double>> brightness(const Exam& exam) {
  const Grid& grid = exam.stack.grid();
  std::vector<std::vector<double>> out(exam.stack.images.phases.size(),
                                       std::vector<double>(grid.count()));
  for (int k = 0; k < grid.size[2]; ++k) {
    std::vector<double> all;
    const std::size_t first = grid.offset(0, 0, k);
    for (const auto& phase : exam.stack.images.phases) {
      for (std::size_t v = 0; v < grid.slice_count(); ++v) all.push_back(phase[first + v]);
    }
    const double low = percentile(all, 0.01);
    const double high = percentile(all, 0.995);
    for (std::size_t p = 0; p < out.size(); ++p) {
      for (std::size_t v = first; v < first + grid.slice_count(); ++v) {
        const double share = (exam.stack.images.phases[p][v] - low) / (high - low);
        out[p][v] = std::sqrt(std::clamp(share, 0.0, 1.2));
      }
    }
  }
  return out;
}

/// Log-probabilities times 16 that the logits stand for.
std::vector<double> stored(const std::vector<double>& logits) {
  double sum = 0;
  for (const double logit : logits) sum += std::exp(logit);
  std::vector<double> out;
  for (const double logit : logits) out.push_back(16 * std::max(-8.0, logit - std::log(sum)));
  return out;
}

TEST(HeartPrior, IsWhatTheNetworkSaysOfEveryChannel) {
  // Slices 5 mm apart: neighbours two away; of the second slice the first, 5 mm away.
  const Exam exam = made::rough_exam(made::turned_grid({23, 18, 6}, {2, 2, 5}), 3);
  const Model model = Model::load(made::model_file("pixelwise"));
  StageContext context;
  const PriorCycle prior = heart_prior(exam, model, context);
  ASSERT_EQ(prior.grid.size, exam.stack.grid().size);
  ASSERT_EQ(prior.phase_count(), 3);
  EXPECT_EQ(prior.labels, (std::vector<std::uint8_t>{0, 1, 2, 3, 4, 5, 6, 7}));
  const auto shown = brightness(exam);
  const Grid& grid = prior.grid;
  constexpr std::array<int, 6> kBelow{-1, 0, 0, 1, 2, 3};
  constexpr std::array<int, 6> kAbove{2, 3, 4, 5, 5, -1};
  int off = 0;
  int least = 0;
  for (int p = 0; p < 3; ++p) {
    ASSERT_EQ(prior.phases[static_cast<std::size_t>(p)].size(), 8 * grid.count());
    const auto& frame = shown[static_cast<std::size_t>(p)];
    for (int k = 0; k < 6; ++k) {
      for (std::size_t v = 0; v < grid.slice_count(); ++v) {
        const std::size_t here = grid.offset(0, 0, k) + v;
        const auto beside = [&](int slice) {
          return slice < 0 ? 0.0 : frame[grid.offset(0, 0, slice) + v];
        };
        const double mean = (shown[0][here] + shown[1][here] + shown[2][here]) / 3;
        double squares = 0;
        for (const auto& phase : shown) squares += (phase[here] - mean) * (phase[here] - mean);
        // In the order of the model: mean, frame, above, deviation, below.
        const std::array<double, 5> channels{
            mean, frame[here], beside(kAbove[static_cast<std::size_t>(k)]),
            4 * std::sqrt(squares / 3), beside(kBelow[static_cast<std::size_t>(k)])};
        std::vector<double> logits;
        for (int o = 0; o < 8; ++o) {
          logits.push_back(made::bias(o));
          for (int c = 0; c < 5; ++c) {
            logits.back() += made::weight(o, c) * channels[static_cast<std::size_t>(c)];
          }
        }
        const std::vector<double> wanted = stored(logits);
        for (std::size_t o = 0; o < 8; ++o) {
          const int found = prior.phases[static_cast<std::size_t>(p)][o * grid.count() + here];
          off += std::abs(found - wanted[o]) > 0.51 ? 1 : 0;
          least += found == -128 ? 1 : 0;
        }
      }
    }
  }
  EXPECT_EQ(off, 0);
  EXPECT_GT(least, 0);  // the least is reached
}

TEST(HeartPrior, ANetworkOfFramesWithFourOutputsStandsIn) {
  const Exam exam = made::rough_exam(made::turned_grid({9, 11, 1}, {2, 2, 8}), 1);
  const Model model = Model::load(made::model_file("frame_alone"));
  StageContext context;
  const PriorCycle prior = heart_prior(exam, model, context);
  EXPECT_EQ(prior.labels, (std::vector<std::uint8_t>{0, 3, 1, 2}));
  const auto shown = brightness(exam);
  for (std::size_t v = 0; v < prior.grid.count(); ++v) {
    std::vector<double> logits;
    for (int o = 0; o < 4; ++o) {
      logits.push_back(made::bias(o) + made::weight(o, 0) * shown[0][v]);
    }
    const std::vector<double> wanted = stored(logits);
    for (std::size_t o = 0; o < 4; ++o) {
      EXPECT_NEAR(prior.phases[0][o * prior.grid.count() + v], wanted[o], 0.51);
    }
  }
}

TEST(HeartPrior, IsTheSameForAnyNumberOfThreads) {
  const Exam exam = made::rough_exam(made::turned_grid({75, 61, 5}, {1.4, 1.3, 8}), 4);
  const Model model = Model::load(made::model_file("unet"));
  StageContext context;
  set_thread_count(1);
  const PriorCycle one = heart_prior(exam, model, context);
  for (const int threads : {2, 5, 0}) {
    set_thread_count(threads);
    const PriorCycle more = heart_prior(exam, model, context);
    EXPECT_EQ(one.phases, more.phases) << threads;
  }
  set_thread_count(0);
  // It tells things apart: not all voxels are of the same kind.
  EXPECT_NE(*std::min_element(one.phases[0].begin(), one.phases[0].end()),
            *std::max_element(one.phases[0].begin(), one.phases[0].end()));
}

TEST(HeartPrior, ExamsOfTwoPhasesAndOfOneSliceHaveOne) {
  const Model model = Model::load(made::model_file("unet"));
  for (const auto& [size, phases] :
       {std::pair{Index3{30, 40, 3}, 2}, std::pair{Index3{40, 30, 1}, 5},
        std::pair{Index3{1, 1, 1}, 1}, std::pair{Index3{3, 50, 2}, 1}}) {
    const Exam exam = made::rough_exam(made::turned_grid(size, {1.5, 1.5, 10}), phases);
    StageContext context;
    const PriorCycle prior = heart_prior(exam, model, context);
    EXPECT_EQ(prior.phase_count(), phases);
    EXPECT_EQ(prior.phases.back().size(), 8 * prior.grid.count());
    for (const std::int8_t value : prior.phases.back()) EXPECT_LE(value, 0);
  }
}

/// Of each voxel, where it lies after a half turn about the axis along which they keep their order.
std::vector<std::size_t> after_half_turn(const Grid& grid, int about) {
  std::vector<std::size_t> out;
  for (int k = 0; k < grid.size[2]; ++k) {
    for (int j = 0; j < grid.size[1]; ++j) {
      for (int i = 0; i < grid.size[0]; ++i) {
        out.push_back(grid.offset(about == 0 ? i : grid.size[0] - 1 - i,
                                  about == 1 ? j : grid.size[1] - 1 - j,
                                  about == 2 ? k : grid.size[2] - 1 - k));
      }
    }
  }
  return out;
}

Exam turned_exam(const Exam& exam, const std::vector<std::size_t>& there) {
  Exam out = exam;
  for (std::size_t p = 0; p < out.stack.images.phases.size(); ++p) {
    for (std::size_t v = 0; v < there.size(); ++v) {
      out.stack.images.phases[p][v] = exam.stack.images.phases[p][there[v]];
    }
  }
  return out;
}

TEST(HeartPrior, AMeanOverOrientationsTurnsWithTheExam) {
  const made::Folder folder;
  const Exam exam = made::rough_exam(made::turned_grid({32, 48, 3}, {2, 2, 8}), 2);
  for (const int orientations : {1, 8}) {
    const Model model = Model::load(folder.copy_of(
        "unet", {}, [&](nlohmann::json& card) { card["orientations"] = orientations; }));
    StageContext context;
    const PriorCycle prior = heart_prior(exam, model, context);
    const Grid& grid = prior.grid;
    for (const int about : {0, 1, 2}) {
      const std::vector<std::size_t> there = after_half_turn(grid, about);
      const PriorCycle turned = heart_prior(turned_exam(exam, there), model, context);
      int most = 0;
      for (std::size_t v = 0; v < there.size(); ++v) {
        for (std::size_t o = 0; o < 8; ++o) {
          most = std::max(most, std::abs(prior.phases[1][o * grid.count() + v] -
                                         turned.phases[1][o * grid.count() + there[v]]));
        }
      }
      if (orientations == 8) {
        EXPECT_LE(most, 1) << about;  // sums in another order, rounded
      } else {
        EXPECT_GT(most, 8) << about;  // a network by itself sees a turned slice otherwise
      }
    }
  }
}

TEST(HeartPrior, NeighboursOfALongBeatShareTheOrientations) {
  for (const int orientations : {2, 3, 4, 8}) {
    const TurnsOfImages turns(orientations, 300);
    for (const auto& [slice, phase] : {std::pair{3, 6}, std::pair{0, 0}, std::pair{4, 1}}) {
      std::set<int> seen;
      for (const int k : {slice, slice + 1}) {
        for (const int p : {phase, phase + 1}) {
          const Turns here = turns.of(k, p);
          EXPECT_EQ(here.count, 2);
          for (int n = 0; n < here.count; ++n) seen.insert(here.first + n);
        }
      }
      // Up to four are complete in any two neighbours.
      if (orientations <= 4) {
        const Turns here = turns.of(slice, phase);
        for (const Turns& beside : {turns.of(slice, phase + 1), turns.of(slice + 1, phase)}) {
          EXPECT_EQ(std::min(here.first, beside.first), 0);
          EXPECT_EQ(std::max(here.first + here.count, beside.first + beside.count), orientations);
        }
      }
      EXPECT_EQ(static_cast<int>(seen.size()), orientations);
      EXPECT_EQ(*seen.rbegin(), orientations - 1);
    }
  }
  EXPECT_EQ(TurnsOfImages(1, 300).of(1, 0).count, 1);
  EXPECT_EQ(TurnsOfImages(8, 75).of(1, 0).count, 8);  // few images: all in each
  EXPECT_EQ(TurnsOfImages(8, 76).of(1, 0).count, 4);
  EXPECT_EQ(TurnsOfImages(8, 100000).of(1, 0).count, 2);
}

TEST(HeartPrior, StopsWhenAskedAndTellsHowFarItIs) {
  const Exam exam = made::rough_exam(made::turned_grid({30, 40, 6}, {2, 2, 8}), 3);
  const Model model = Model::load(made::model_file("unet"));
  StageContext context;
  std::atomic<bool> stop{false};
  context.cancel = &stop;
  std::mutex mutex;
  double farthest = 0;
  context.progress_sink = [&](double share, std::string_view) {
    const std::lock_guard lock(mutex);
    EXPECT_GE(share, 0);
    EXPECT_LE(share, 1);
    farthest = std::max(farthest, share);
  };
  (void)heart_prior(exam, model, context);
  EXPECT_GT(farthest, 0.9);
  context.progress_sink = [&](double share, std::string_view) { stop = share > 0.5; };
  try {
    (void)heart_prior(exam, model, context);
    ADD_FAILURE() << "it went on";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::Machine);
  }
}

TEST(HeartPrior, AnExamWithoutImagesIsRefused) {
  const Model model = Model::load(made::model_file("unet"));
  StageContext context;
  EXPECT_TRUE(
      made::tells(made::refusal([&] { (void)heart_prior({}, model, context); }), "no images"));
}

}  // namespace
}  // namespace beatlas::prior
