/// What is no heart is not taken for one.
#include <cmath>

#include <gtest/gtest.h>

#include "tests/clinical_part.h"
#include "tests/made_images.h"
#include "tests/unit/segment/imaged_phantom.h"

namespace beatlas::segment {
namespace {

using made::BeatingEllipsoid;

constexpr int kPhases = 5;
/// 700 ml at most, 582 ml at least, as a heart with its cavities; axes oblique to the grid.
BeatingEllipsoid plain() {
  BeatingEllipsoid body;
  body.centre_lps = Vec3(15, -25, 40);
  body.lps_from_axes =
      (Eigen::AngleAxisd(0.6, Vec3::UnitX()) * Eigen::AngleAxisd(-0.5, Vec3::UnitY()) *
       Eigen::AngleAxisd(0.3, Vec3::UnitZ()))
          .toRotationMatrix();
  body.largest_mm = Vec3(48, 53, 65.7);
  body.squeeze = 1 - std::cbrt(582.0 / 700.0);
  return body;
}

Grid plain_grid() { return made::oblique_grid({140, 140, 54}, {1, 1, 3}, Vec3(12, -20, 44)); }

std::string refusal_of(const Exam& exam) {
  return made::refusal([&] { (void)made::segmented(exam); });
}

TEST(Refusal, OfABeatingBodyWithoutChambers) {
  Exam exam = made::ellipsoid_exam(plain_grid(), plain(), kPhases, 400, 100);
  made::add_rician_noise(exam.stack.images, 20, 5);
  EXPECT_NE(refusal_of(exam).find("no heart found"), std::string::npos);
}

TEST(Refusal, OfStillImagesInAirWhoseNoiseIsRician) {
  BeatingEllipsoid still = plain();
  still.squeeze = 0;
  for (int phases : {2, 15}) {
    Exam exam = made::ellipsoid_exam(made::oblique_grid({96, 96, 40}, {2, 2, 4}, {12, -20, 44}),
                                     still, phases, 400, 0);
    made::add_rician_noise(exam.stack.images, 20, 6);
    EXPECT_NE(refusal_of(exam).find("no heart found"), std::string::npos);
  }
}

TEST(Refusal, OfASinglePhase) {
  const Exam exam = made::ellipsoid_exam(plain_grid(), plain(), 1, 400, 100);
  EXPECT_NE(refusal_of(exam).find("one phase"), std::string::npos);
}

TEST(Refusal, OfConstantImages) {
  Exam exam = made::ellipsoid_exam(made::straight_grid({32, 32, 8}, {2, 2, 6}), plain(), 4, 0, 0);
  for (float value : {0.0F, 4095.0F}) {
    exam.stack.images = made::constant_images(exam.stack.images.grid, 4, value);
    EXPECT_NE(refusal_of(exam).find("no heart found"), std::string::npos);
  }
}

TEST(Cancel, StopsTheSegmentation) {
  phantom::PhantomSpec spec = made::clinical_part();
  spec.phases = 4;
  const made::ImagedPhantom imaged(spec);
  const std::atomic<bool> stop{true};
  StageContext context;
  context.cancel = &stop;
  EXPECT_THROW((void)segment_exam(imaged.exam, {}, {}, context, {}, &imaged.prior()), Error);
}

}  // namespace
}  // namespace beatlas::segment
