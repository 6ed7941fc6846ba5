#include "pipeline/core/stage_context.h"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "pipeline/core/parallel.h"
#include "runtime/base/error.h"

namespace beatlas {
namespace {

struct Told {
  std::mutex mutex;
  std::vector<std::pair<double, std::string>> all;

  [[nodiscard]] StageContext context() {
    StageContext out;
    out.progress_sink = [this](double share, std::string_view step) {
      const std::lock_guard lock(mutex);
      all.emplace_back(share, step);
    };
    return out;
  }
};

TEST(StageContext, APartIsWithinTheWholeAndCarriesItsName) {
  Told told;
  const StageContext whole = told.context();
  const StageContext heart = whole.part(0.5, 1, "heart");
  heart.progress(0.5, "phase 3 of 5");
  heart.part(0.5, 1).progress(0.5);
  whole.part(0, 0.5, "lv").part(0, 0.5, "motion").progress(1, "1 of 2");
  ASSERT_EQ(told.all.size(), 3U);
  EXPECT_EQ(told.all[0], std::pair(0.75, std::string("heart, phase 3 of 5")));
  EXPECT_EQ(told.all[1], std::pair(0.875, std::string("heart")));
  EXPECT_EQ(told.all[2], std::pair(0.25, std::string("lv, motion, 1 of 2")));
  StageContext().part(0, 1, "quiet").progress(1, "no one listens");
}

TEST(StageContext, APartIsCancelledWithTheWhole) {
  std::atomic<bool> cancel{false};
  StageContext whole;
  whole.cancel = &cancel;
  const StageContext part = whole.part(0, 1, "part");
  EXPECT_NO_THROW(part.check_cancelled());
  cancel = true;
  EXPECT_THROW(part.check_cancelled(), Error);
}

TEST(Parallel, TellsEachOfItsBodiesOnce) {
  Told told;
  std::atomic<int> done{0};
  parallel_for(20, told.context(), "phase", [&](std::size_t) { ++done; });
  EXPECT_EQ(done, 20);
  ASSERT_EQ(told.all.size(), 20U);
  std::sort(told.all.begin(), told.all.end());
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_DOUBLE_EQ(told.all[i].first, static_cast<double>(i) / 20);
    EXPECT_EQ(told.all[i].second, "phase " + std::to_string(i + 1) + " of 20");
  }
}

TEST(Parallel, BeginsNoBodyOnceItIsToStop) {
  std::atomic<bool> stop{false};
  set_stop_flag(&stop);
  std::atomic<int> done{0};
  const auto body = [&](std::size_t) {
    ++done;
    stop = true;
  };
  EXPECT_THROW(parallel_for(100000, body), Error);
  // Those that had begun in other threads come to their end.
  EXPECT_LT(done, 1000);
  EXPECT_THROW(check_stop_flag(), Error);
  set_stop_flag(nullptr);
  EXPECT_NO_THROW(check_stop_flag());
  done = 0;
  parallel_for(10, body);
  EXPECT_EQ(done, 10);
}

}  // namespace
}  // namespace beatlas
