"""What is learnt: parameters, and how the numbers of a network follow from them."""
