/// ITK's filters, in a translation unit of their own: its templates are heavy.
#include <itkConfidenceConnectedImageFilter.h>
#include <itkConnectedThresholdImageFilter.h>
#include <itkImportImageFilter.h>
#include <itkNeighborhoodConnectedImageFilter.h>
#include <itkSignedMaurerDistanceMapImageFilter.h>

#include "tests/bench/alternatives.h"

namespace beatlas::bench {
namespace {

using FloatImage = itk::Image<float, 3>;
using MaskImage = itk::Image<std::uint8_t, 3>;

/// A view of the voxels, nothing is copied.
template <class T>
typename itk::Image<T, 3>::Pointer image_of(const Grid& grid, const std::vector<T>& voxels) {
  const auto import = itk::ImportImageFilter<T, 3>::New();
  typename itk::ImportImageFilter<T, 3>::SizeType size;
  typename itk::ImportImageFilter<T, 3>::IndexType start;
  typename itk::ImportImageFilter<T, 3>::SpacingType spacing;
  for (unsigned axis = 0; axis < 3; ++axis) {
    size[axis] = static_cast<itk::SizeValueType>(grid.size[axis]);
    start[axis] = 0;
    spacing[axis] = grid.spacing_mm()[axis];
  }
  import->SetRegion({start, size});
  import->SetSpacing(spacing);
  import->SetImportPointer(const_cast<T*>(voxels.data()), voxels.size(), false);
  import->Update();
  return import->GetOutput();
}

template <class T>
std::vector<T> voxels_of(const itk::Image<T, 3>& image) {
  const T* first = image.GetBufferPointer();
  return {first, first + image.GetBufferedRegion().GetNumberOfPixels()};
}

FloatImage::IndexType index_of(const Index3& seed) {
  FloatImage::IndexType out;
  for (unsigned axis = 0; axis < 3; ++axis) out[axis] = seed[axis];
  return out;
}

}  // namespace

Mask itk_connected_threshold(const Grid& grid, const std::vector<float>& image,
                             const Growing& growing) {
  const auto filter = itk::ConnectedThresholdImageFilter<FloatImage, MaskImage>::New();
  filter->SetInput(image_of(grid, image));
  filter->SetSeed(index_of(growing.seed));
  filter->SetLower(static_cast<float>(growing.lower));
  filter->SetUpper(static_cast<float>(growing.upper));
  filter->SetReplaceValue(1);
  filter->Update();
  return voxels_of(*filter->GetOutput());
}

Mask itk_confidence_connected(const Grid& grid, const std::vector<float>& image,
                              const Growing& growing) {
  const auto filter = itk::ConfidenceConnectedImageFilter<FloatImage, MaskImage>::New();
  filter->SetInput(image_of(grid, image));
  filter->SetSeed(index_of(growing.seed));
  filter->SetMultiplier(2.5);
  filter->SetNumberOfIterations(4);
  filter->SetInitialNeighborhoodRadius(2);
  filter->SetReplaceValue(1);
  filter->Update();
  return voxels_of(*filter->GetOutput());
}

Mask itk_neighborhood_connected(const Grid& grid, const std::vector<float>& image,
                                const Growing& growing) {
  const auto filter = itk::NeighborhoodConnectedImageFilter<FloatImage, MaskImage>::New();
  filter->SetInput(image_of(grid, image));
  filter->SetSeed(index_of(growing.seed));
  filter->SetLower(static_cast<float>(growing.lower));
  filter->SetUpper(static_cast<float>(growing.upper));
  FloatImage::SizeType radius;
  radius.Fill(1);
  filter->SetRadius(radius);
  filter->SetReplaceValue(1);
  filter->Update();
  return voxels_of(*filter->GetOutput());
}

std::vector<float> itk_signed_maurer(const Grid& grid, const Mask& mask) {
  const auto filter = itk::SignedMaurerDistanceMapImageFilter<MaskImage, FloatImage>::New();
  filter->SetInput(image_of(grid, mask));
  filter->SetBackgroundValue(0);
  filter->SetUseImageSpacing(true);
  filter->SetSquaredDistance(false);
  filter->SetInsideIsPositive(false);
  filter->Update();
  return voxels_of(*filter->GetOutput());
}

std::vector<float> itk_symmetric_maurer(const Grid& grid, const Mask& mask) {
  Mask rest(mask.size());
  for (std::size_t n = 0; n < mask.size(); ++n) rest[n] = mask[n] == 0 ? 1 : 0;
  std::vector<float> out = itk_signed_maurer(grid, mask);
  const std::vector<float> of_rest = itk_signed_maurer(grid, rest);
  for (std::size_t n = 0; n < out.size(); ++n) out[n] = 0.5F * (out[n] - of_rest[n]);
  return out;
}

}  // namespace beatlas::bench
