// A label image as ITK, and so 3D Slicer and ITK-SNAP, reads and writes it:
// itk_paint IN.nii.gz OUT.nii.gz X Y Z RADIUS LABEL [PHASE]
// Paints a ball around a place in LPS [mm], of a 4-D image in one phase, and prints origin, spacing
// and direction, column by column.
#include <cstdlib>
#include <iostream>

#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkImageFileWriter.h>
#include <itkImageRegionIteratorWithIndex.h>
#include <itkNiftiImageIO.h>

namespace {

template <unsigned Dimension>
void paint(char** words, int phase) {
  using Image = itk::Image<unsigned char, Dimension>;
  const auto reader = itk::ImageFileReader<Image>::New();
  reader->SetImageIO(itk::NiftiImageIO::New());
  reader->SetFileName(words[1]);
  reader->Update();
  const typename Image::Pointer image = reader->GetOutput();
  const double radius = std::atof(words[6]);
  itk::ImageRegionIteratorWithIndex<Image> at(image, image->GetBufferedRegion());
  for (; !at.IsAtEnd(); ++at) {
    if (Dimension == 4 && at.GetIndex()[Dimension - 1] != phase) continue;
    typename Image::PointType place;
    image->TransformIndexToPhysicalPoint(at.GetIndex(), place);
    double square = 0;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const double away = place[axis] - std::atof(words[3 + axis]);
      square += away * away;
    }
    if (square <= radius * radius) at.Set(static_cast<unsigned char>(std::atoi(words[7])));
  }
  for (unsigned axis = 0; axis < 3; ++axis) std::cout << image->GetOrigin()[axis] << " ";
  for (unsigned axis = 0; axis < 3; ++axis) std::cout << image->GetSpacing()[axis] << " ";
  for (unsigned column = 0; column < 3; ++column) {
    for (unsigned row = 0; row < 3; ++row) std::cout << image->GetDirection()(row, column) << " ";
  }
  const auto writer = itk::ImageFileWriter<Image>::New();
  writer->SetImageIO(itk::NiftiImageIO::New());
  writer->SetFileName(words[2]);
  writer->SetInput(image);
  writer->SetUseCompression(true);
  writer->Update();
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 8 && argc != 9) return 2;
  std::cout.precision(9);
  if (argc == 8) paint<3>(argv, 0);
  if (argc == 9) paint<4>(argv, std::atoi(argv[8]));
  return 0;
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 1;
}
