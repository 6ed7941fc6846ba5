#include "pipeline/report/encoded_picture.h"

#include <algorithm>

#include <vtkImageData.h>
#include <vtkJPEGWriter.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkUnsignedCharArray.h>

#include "runtime/base/error.h"

namespace beatlas::report {
namespace {

/// VTK counts rows from below and has red first.
vtkNew<vtkImageData> image_of(const cv::Mat& picture) {
  const int channels = picture.channels();
  vtkNew<vtkImageData> out;
  out->SetDimensions(picture.cols, picture.rows, 1);
  out->AllocateScalars(VTK_UNSIGNED_CHAR, channels);
  for (int row = 0; row < picture.rows; ++row) {
    const auto* from = picture.ptr<std::uint8_t>(picture.rows - 1 - row);
    auto* to = static_cast<std::uint8_t*>(out->GetScalarPointer(0, row, 0));
    for (int at = 0; at < picture.cols * channels; at += channels) {
      std::reverse_copy(from + at, from + at + channels, to + at);
    }
  }
  return out;
}

std::vector<std::uint8_t> bytes_of(vtkUnsignedCharArray* bytes) {
  if (bytes == nullptr || bytes->GetNumberOfValues() == 0) {
    throw Error(ErrorCode::Machine, "a picture could not be encoded");
  }
  return {bytes->GetPointer(0), bytes->GetPointer(0) + bytes->GetNumberOfValues()};
}

}  // namespace

std::vector<std::uint8_t> png_of(const cv::Mat& picture) {
  const vtkNew<vtkImageData> image = image_of(picture);
  const vtkNew<vtkPNGWriter> writer;
  writer->SetInputData(image);
  writer->WriteToMemoryOn();
  writer->Write();
  return bytes_of(writer->GetResult());
}

std::vector<std::uint8_t> jpeg_of(const cv::Mat& picture, int quality) {
  const vtkNew<vtkImageData> image = image_of(picture);
  const vtkNew<vtkJPEGWriter> writer;
  writer->SetInputData(image);
  writer->SetQuality(quality);
  writer->ProgressiveOff();
  writer->WriteToMemoryOn();
  writer->Write();
  return bytes_of(writer->GetResult());
}

}  // namespace beatlas::report
