/* Straightforward support vector machine for comparison: libm's expf, one vector after the other.
   With CMSIS defined it calls CMSIS-DSP on the same vectors. */
#ifndef PLAIN_SVM_H
#define PLAIN_SVM_H

#include "fc_svm.h"
#include "plain_svm_model.h"

fc_status plain_svm(const float *window, fc_prediction *prediction);

#endif
