"""What pydicom sees in a folder of DICOM files, as JSON, by slice position and trigger time."""
import json
import os
import sys

import pydicom

images = []
for folder, _, names in os.walk(sys.argv[1]):
    for name in names:
        d = pydicom.dcmread(os.path.join(folder, name))
        images.append({
            "position": [float(v) for v in d.ImagePositionPatient],
            "orientation": [float(v) for v in d.ImageOrientationPatient],
            "spacing": [float(v) for v in d.PixelSpacing],
            "longest_ds": max(len(str(v)) for key in
                              ("ImagePositionPatient", "ImageOrientationPatient", "PixelSpacing")
                              for v in d[key].value),
            "trigger_ms": float(d.TriggerTime),
            "rr_ms": int(d.NominalInterval),
            "number_of_images": int(d.CardiacNumberOfImages),
            "series": d.SeriesInstanceUID,
            "study": d.StudyInstanceUID,
            "instance": d.SOPInstanceUID,
            "meta_instance": d.file_meta.MediaStorageSOPInstanceUID,
            "class": d.SOPClassUID,
            "syntax": d.file_meta.TransferSyntaxUID,
            "name": str(d.PatientName),
            "id": str(d.PatientID),
            "pixels": d.pixel_array.astype(int).tolist(),
        })
images.sort(key=lambda i: (i["series"], i["position"], i["trigger_ms"]))
json.dump(images, sys.stdout)
