"""Estimators of the spacecraft's own state and plant, in front of controllers.

:mod:`.attitude_kernel` is the Kalman filter of attitude and gyro bias. :mod:`.plant_kernel`, :mod:`.torque_kernel` and
:mod:`.wheel_kernel` are the multiple-model estimator of inertia, momentum and faulty wheels. :mod:`.prediction_kernel`
is the prediction over the loop delay. :mod:`.models` builds their models from a scenario, and :mod:`.navigator` puts
them in a row.
"""
