#include "pipeline/build/fingerprint.h"

#include <set>

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace beatlas::build
