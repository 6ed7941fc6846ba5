#include "pipeline/ingest/dicom_words.h"

#include <algorithm>
#include <string>

#include <vtkDICOMDataElement.h>
#include <vtkDICOMItem.h>
#include <vtkDICOMMetaData.h>
#include <vtkDICOMValue.h>

namespace beatlas::ingest {
namespace {

constexpr unsigned kMostUnknown = 4096;  // bytes; a larger unknown value is no text
constexpr int kMostDepth = 16;           // of sequences in sequences

/// What kind of image it is; values of the standard, met in every exam.
bool of_the_image(const vtkDICOMTag& tag) {
  return tag == DC::ImageType || tag == DC::FrameType || tag == DC::Modality ||
         tag == DC::PhotometricInterpretation;
}

/// What names a person, however short.
bool of_the_person(const vtkDICOMTag& tag, const vtkDICOMVR& vr) {
  return vr == vtkDICOMVR::PN || tag == DC::PatientID || tag == DC::OtherPatientIDs ||
         tag == DC::AccessionNumber;
}

void add_value(const vtkDICOMTag& tag, const vtkDICOMValue& value, int depth, IdentityWords& words);

void add_item(const vtkDICOMItem& item, int depth, IdentityWords& words) {
  for (auto it = item.Begin(); it != item.End(); ++it) {
    add_value(it->GetTag(), it->GetValue(), depth, words);
  }
}

void add_unknown(const vtkDICOMValue& value, IdentityWords& words) {
  const unsigned char* bytes = value.GetUnsignedCharData();
  const std::size_t count = value.GetNumberOfValues();  // its VL is one more where that is odd
  if (!bytes || count > kMostUnknown) return;
  words.add_text(std::string(bytes, bytes + count));
}

void add_value(const vtkDICOMTag& tag, const vtkDICOMValue& value, int depth,
               IdentityWords& words) {
  if (!value.IsValid() || depth > kMostDepth) return;
  if (const vtkDICOMValue* several = value.GetMultiplexData()) {
    for (std::size_t i = 0; i < value.GetNumberOfValues(); ++i) {
      add_value(tag, several[i], depth + 1, words);
    }
    return;
  }
  const vtkDICOMVR vr = value.GetVR();
  if (vr == vtkDICOMVR::SQ) {
    const vtkDICOMItem* items = value.GetSequenceData();
    for (std::size_t i = 0; items && i < value.GetNumberOfValues(); ++i) {
      add_item(items[i], depth + 1, words);
    }
  } else if (vr == vtkDICOMVR::UN) {
    add_unknown(value, words);
  } else if (vr == vtkDICOMVR::UI) {
    const std::string uid = value.AsString();
    if (uid.rfind("1.2.840.10008.", 0) != 0) words.add_uid(uid);
  } else if (vr.HasTextValue() && vr != vtkDICOMVR::DS && vr != vtkDICOMVR::IS &&
             !of_the_image(tag)) {
    if (of_the_person(tag, vr)) {
      words.add_identity(value.AsUTF8String());
    } else {
      words.add_text(value.AsUTF8String());
    }
  }
}

}  // namespace

void add_words(vtkDICOMMetaData& meta, IdentityWords& words) {
  for (auto it = meta.Begin(); it != meta.End(); ++it) {
    add_value(it->GetTag(), it->GetValue(), 0, words);
  }
}

}  // namespace beatlas::ingest
