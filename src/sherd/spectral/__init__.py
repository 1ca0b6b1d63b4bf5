"""Floor 3: operators, eigenbasis, geodesics, sampling."""
