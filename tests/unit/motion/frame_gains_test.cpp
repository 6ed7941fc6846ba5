#include "pipeline/motion/frame_gains.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "pipeline/phantom/render.h"

namespace beatlas::motion {
namespace {

/// The phantom `small` in six phases and thick slices.
const Exam& even_exam() {
  static const Exam exam = [] {
    phantom::PhantomSpec spec = phantom::preset("small");
    spec.phases = 6;
    spec.grid = phantom::on_matrix(spec.grid, Index3{64, 64, 12}, Vec3::Zero());
    StageContext context;
    Exam out;
    out.stack = phantom::render(phantom::Phantom(spec), context).cine;
    return out;
  }();
  return exam;
}

void scale(ImageCycle<float>& images, std::size_t phase, int k, float by) {
  const std::size_t begin = images.grid.offset(0, 0, k);
  for (std::size_t v = begin; v < begin + images.grid.slice_count(); ++v)
    images.phases[phase][v] *= by;
}

double most_off(const std::vector<std::vector<double>>& gains) {
  double most = 0;
  for (const auto& of_slice : gains) {
    for (const double gain : of_slice) most = std::max(most, std::abs(gain - 1));
  }
  return most;
}

TEST(FrameGains, OfABeatingHeartAreNone) {
  EXPECT_LT(most_off(frame_gains(even_exam().stack.images)), 0.02);
  const Exam same = with_even_frames(even_exam());
  EXPECT_EQ(same.stack.images.phases, even_exam().stack.images.phases);
  EXPECT_TRUE(same.decisions.empty());
}

TEST(FrameGains, AreTakenOffWhereTheFirstFramesAreBright) {
  Exam exam = even_exam();
  for (int k = 0; k < exam.stack.grid().size[2]; ++k) {
    scale(exam.stack.images, 0, k, 1.7F);
    scale(exam.stack.images, 1, k, 1.15F);
  }
  scale(exam.stack.images, 4, 5, 0.6F);
  const auto gains = frame_gains(exam.stack.images);
  for (std::size_t k = 0; k < gains.size(); ++k) {
    EXPECT_NEAR(gains[k][0], 1.7, 0.05) << k;
    EXPECT_NEAR(gains[k][1], 1.15, 0.04) << k;
    EXPECT_NEAR(gains[k][4], k == 5 ? 0.6 : 1.0, 0.03) << k;
  }
  const Exam even = with_even_frames(std::move(exam));
  EXPECT_LT(most_off(frame_gains(even.stack.images)), 0.01);
  ASSERT_EQ(even.decisions.size(), 1U);
  EXPECT_NE(even.decisions[0].find("25 of 72 images; most "), std::string::npos)
      << even.decisions[0];
  EXPECT_NE(even.decisions[0].find("% brighter, phase 0 of slice"), std::string::npos)
      << even.decisions[0];
}

TEST(FrameGains, AreNoneOfImagesThatDoNotCountFromNothing) {
  ImageCycle<float> images = even_exam().stack.images;
  float brightest = 0;
  for (const std::vector<float>& phase : images.phases) {
    brightest = std::max(brightest, *std::max_element(phase.begin(), phase.end()));
  }
  for (std::vector<float>& phase : images.phases) {
    for (float& value : phase) value -= 0.4F * brightest;
  }
  EXPECT_EQ(most_off(frame_gains(images)), 0);
}

TEST(FrameGains, OfTwoPhasesLieAboutTheirMiddle) {
  Exam exam = even_exam();
  exam.stack.images.phases.resize(2);
  for (int k = 0; k < exam.stack.grid().size[2]; ++k) scale(exam.stack.images, 0, k, 1.3F);
  for (const auto& of_slice : frame_gains(exam.stack.images))
    EXPECT_NEAR(of_slice[0] / of_slice[1], 1.3, 0.03);
}

TEST(FrameGains, AreNoneOfAFrameThatShowsNoise) {
  Exam exam = even_exam();
  std::mt19937 random(3);
  std::uniform_real_distribution<float> noise(1, 40);
  for (float& value : exam.stack.images.phases[2]) value = noise(random);
  for (const auto& of_slice : frame_gains(exam.stack.images)) EXPECT_EQ(of_slice[2], 1.0);
  EXPECT_TRUE(with_even_frames(std::move(exam)).decisions.empty());
}

TEST(FrameGains, AreTakenOffViewsToo) {
  Exam exam = even_exam();
  exam.views.push_back(exam.stack);
  for (float& value : exam.views[0].images.phases[3]) value *= 2;
  const Exam even = with_even_frames(std::move(exam));
  EXPECT_LT(most_off(frame_gains(even.views[0].images)), 0.02);
  EXPECT_EQ(even.stack.images.phases, even_exam().stack.images.phases);
}

}  // namespace
}  // namespace beatlas::motion
