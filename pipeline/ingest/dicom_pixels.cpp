#include "pipeline/ingest/dicom_pixels.h"

#include <vtkDICOMReader.h>
#include <vtkExecutive.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkType.h>

#include "pipeline/ingest/vtk_silence.h"
#include "runtime/base/error.h"

namespace beatlas::ingest {
namespace {

template <class Stored>
std::vector<float> as_float(const void* data, std::size_t first, std::size_t count) {
  const auto* begin = static_cast<const Stored*>(data) + first;
  std::vector<float> out(count);
  for (std::size_t i = 0; i < count; ++i) out[i] = static_cast<float>(begin[i]);
  return out;
}

std::vector<float> as_float(int type, const void* data, std::size_t first, std::size_t count) {
  switch (type) {
    case VTK_UNSIGNED_CHAR:
      return as_float<unsigned char>(data, first, count);
    case VTK_SIGNED_CHAR:
    case VTK_CHAR:
      return as_float<signed char>(data, first, count);
    case VTK_UNSIGNED_SHORT:
      return as_float<unsigned short>(data, first, count);
    case VTK_SHORT:
      return as_float<short>(data, first, count);
    case VTK_UNSIGNED_INT:
      return as_float<unsigned int>(data, first, count);
    case VTK_INT:
      return as_float<int>(data, first, count);
    case VTK_FLOAT:
      return as_float<float>(data, first, count);
    case VTK_DOUBLE:
      return as_float<double>(data, first, count);
    default:
      return {};
  }
}

std::vector<std::vector<float>> read_file(const DicomImage& image) {
  vtkNew<vtkDICOMReader> reader;
  silence(reader);
  silence(reader->GetExecutive());
  reader->SetFileName(image.file.c_str());
  reader->SortingOff();
  reader->TimeAsVectorOff();
  reader->AutoRescaleOff();
  reader->SetMemoryRowOrderToFileNative();
  reader->Update();
  vtkImageData* data = reader->GetOutput();
  const int* size = data->GetDimensions();
  if (reader->GetErrorCode() != 0 || size[0] != image.columns || size[1] != image.rows ||
      size[2] < 1 || data->GetNumberOfScalarComponents() != 1 || !data->GetScalarPointer()) {
    return {};
  }
  const auto count = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
  std::vector<std::vector<float>> frames(static_cast<std::size_t>(size[2]));
  vtkIntArray* frame_of_slice = reader->GetFrameIndexArray();
  for (int slice = 0; slice < size[2]; ++slice) {
    const int frame = frame_of_slice && slice < frame_of_slice->GetNumberOfValues()
                          ? frame_of_slice->GetValue(slice)
                          : slice;
    if (frame < 0 || frame >= size[2]) return {};
    frames[static_cast<std::size_t>(frame)] =
        as_float(data->GetScalarType(), data->GetScalarPointer(),
                 static_cast<std::size_t>(slice) * count, count);
  }
  return frames;
}

}  // namespace

std::vector<float> DicomPixels::read(const DicomImage& image) {
  if (image.file != file_) {
    frames_ = read_file(image);
    file_ = image.file;
  }
  const auto frame = static_cast<std::size_t>(image.frame);
  if (frame >= frames_.size() || frames_[frame].empty()) {
    throw_invalid(image.file.string() +
                  ": its pixels cannot be decoded; the file is damaged or packed in a way that is "
                  "not supported");
  }
  std::vector<float> out = frames_[frame];
  for (float& value : out) {
    value = static_cast<float>(value * image.rescale_slope + image.rescale_intercept);
  }
  return out;
}

}  // namespace beatlas::ingest
