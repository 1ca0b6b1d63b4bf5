"""Many questions: what is asked, what is known of each, and who computes."""
