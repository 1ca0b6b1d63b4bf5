"""Floor 5: operators, eigenbasis, geodesics, sampling."""
