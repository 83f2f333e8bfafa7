"""Units at the edges: multiply by the constant to get SI. Inside, everything is SI, and propeller speed is in rev/s.

Sources: the international foot and pound and the standard gravity are exact by definition.
"""

from __future__ import annotations

FOOT_M = 0.3048  # [m/ft] exact
INCH_M = FOOT_M / 12.0  # [m/in] exact
POUND_KG = 0.45359237  # [kg/lb] exact
G_M_S2 = 9.80665  # [m/s2] exact standard gravity; the sources' 32.174 ft/s2 is the same within 1e-6
LBF_N = POUND_KG * G_M_S2  # [N/lbf] exact, 4.4482
SLUG_KG = LBF_N / FOOT_M  # [kg/slug] exact, 14.594: the mass that 1 lbf accelerates at 1 ft/s2
RPM_REV_S = 1.0 / 60.0  # [(rev/s)/rpm] exact
