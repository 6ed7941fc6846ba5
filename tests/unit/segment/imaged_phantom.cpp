#include "tests/unit/segment/imaged_phantom.h"

#include "tests/learned.h"

namespace beatlas::made {
namespace {

prior::PriorCycle prior_of(const Exam& exam, Views views) {
  return views == Views::All ? test::learned(exam) : test::learned(exam, BEATLAS_ONE_VIEW_PRIOR);
}

}  // namespace

Segmentation segmented(const Exam& exam, Views views, const std::vector<segment::Seed>& seeds,
                       const segment::SegmentOptions& options) {
  const prior::PriorCycle likely = prior_of(exam, views);
  StageContext context;
  return segment::segment_exam(exam, seeds, options, context, {}, &likely);
}

const prior::PriorCycle& ImagedPhantom::prior() const {
  if (!prior_) prior_ = prior_of(exam, views_);
  return *prior_;
}

}  // namespace beatlas::made
